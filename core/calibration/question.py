"""Questions about an ambiguous file, the user's answers, and remarks on how the file was read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..errors import DimpleError
from ..message import Message, in_a_row


def _asked(label: str, text: str, *choices: str) -> Any:
    """Declare an answer, None by default: its label, its meaning, and its possible values if they are limited."""
    return field(default=None, metadata={"label": label, "text": text, "choices": choices})


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """The user's answers about a file; an answer that is None is detected, or asked for if detection fails."""

    depth_column: str | None = _asked("Depth Column", "Header of the depth column, or its number, counted from 1")
    force_column: str | None = _asked("Force Column", "Header of the force column, or its number, counted from 1")
    depth_unit: str | None = _asked("Depth Unit", "mm, m, um or in")
    force_unit: str | None = _asked("Force Unit", "N, gf, kgf, mN, kN or lbf")
    decimal: str | None = _asked("Decimal", "The decimal mark", ".", ",")
    table: int | None = _asked("Table", "Which of several tables, counted from 1")
    press: str | None = _asked("Sign of Force", "Sign of the force during a press", "positive", "negative")
    cycle: int | None = _asked("Cycle", "Which of several presses, counted from 1")
    contact_mm: float | None = _asked("Touch (mm)", "Depth reading at the first touch; detected unless set")
    tare_n: float | None = _asked(
        "Tare (N)", "Force reading before the touch, with a press positive; detected unless set"
    )
    until_mm: float | None = _asked(
        "Until (mm)", "Leave out rows beyond this depth reading, for example where the object tore"
    )


class Candidate(NamedTuple):
    """A possible answer: its value and its meaning, with a preview of the data."""

    value: str
    label: str


class Question:
    """A question about one field of Answers, and the possible answers.

    name: the field.
    text: the question as a sentence.
    candidates: the possible answers.
    default: value of the likeliest answer, "" if all are equally likely.
    """

    def __init__(self, name: str, text: str, *candidates: tuple[str, str], default: str = "") -> None:
        self.name, self.text, self.default = name, text, default
        self.candidates = tuple(Candidate(*each) for each in candidates)


class Remarks:
    """Remarks on how a file was read: notes, and warnings of possible errors."""

    def __init__(self) -> None:
        self.notes: list[str] = []
        self.warnings: list[str] = []

    def note(self, template: str, **values: Any) -> None:
        """Add a note on how the file was read."""
        self.notes.append(Message(template, **values))

    def warn(self, template: str, **values: Any) -> None:
        """Add a warning of a possible error."""
        self.warnings.append(Message(template, **values))


class Undecided(DimpleError):
    """A file is ambiguous: `questions` ask what is right; a script answers them as keywords of `Answers`."""

    def __init__(self, *questions: Question) -> None:
        self.questions, lines = questions, []
        for question in questions:
            choices = tuple(Message("{value!r} ({label})", value=c.value, label=c.label) for c in question.candidates)
            lines += [question.text, Message("Give {name}: {choices}.", name=question.name, choices=choices)]
        super().__init__(in_a_row(lines))

    def to_record(self) -> dict[str, Any]:
        """Return the open questions as plain data."""
        questions = [{**vars(each), "candidates": [c._asdict() for c in each.candidates]} for each in self.questions]
        return {"questions": questions}
