"""What a file leaves open, what the user answers, and what is said of how it was read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from ..base import DimpleError
from ..messages import Message


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """Answers of the user about a file; what is None is detected, and asked where that fails.

    depth_column: header, or number counted from 1.
    force_column: header, or number counted from 1.
    depth_unit: "mm", "um"...
    force_unit: "N", "gf"...
    decimal: the decimal mark, "." or ",".
    table: which of several tables in the file, counted from 1.
    press: sign of a pressing force, "positive" or "negative".
    inward: sign of a depth that grows as the tip goes in, "positive" or "negative".
    order: whether the rows stand as they were measured, "written", or from the last to the first, "reversed".
    cycle: which of several presses, counted from 1.
    contact_mm: reading of the depth at first touch [mm].
    from_mm: reading of the depth before which rows are left out [mm].
    until_mm: reading of the depth beyond which rows are left out [mm].
    """

    depth_column: str | None = None
    force_column: str | None = None
    depth_unit: str | None = None
    force_unit: str | None = None
    decimal: str | None = None
    table: int | None = None
    press: str | None = None
    inward: str | None = None
    order: str | None = None
    cycle: int | None = None
    contact_mm: float | None = None
    from_mm: float | None = None
    until_mm: float | None = None


class Candidate(NamedTuple):
    """A possible answer: its value, and what it means, with a preview of the data."""

    value: str
    label: str


class Question:
    """A question about one field of Answers, and the answers that are possible.

    name: the field.
    text: the question as a sentence.
    candidates: (value, what it means).
    default: the value of the likeliest, "" where none is likelier.
    """

    def __init__(self, name: str, text: str, *candidates: tuple[str, str], default: str = "") -> None:
        self.name, self.text, self.default = name, text, default
        self.candidates = tuple(Candidate(*each) for each in candidates)

    def mark(self, candidate: Candidate) -> str:
        """Return what stands behind the likeliest answer, "" behind the others."""
        return " (the likeliest)" if candidate.value == self.default else ""


class Remarks:
    """What there is to say of how a file was read: notes, and warnings of what may be wrong."""

    def __init__(self) -> None:
        self.notes: list[str] = []
        self.warnings: list[str] = []

    def note(self, template: str, **values: Any) -> None:
        """Note how the file was read."""
        self.notes.append(Message(template, **values))

    def warn(self, template: str, **values: Any) -> None:
        """Warn of what may be wrong."""
        self.warnings.append(Message(template, **values))


class Undecided(DimpleError):
    """A file can be read in several ways; `questions` ask which is right."""

    def __init__(self, *questions: Question) -> None:
        self.questions = questions
        lines = []
        for question in questions:
            lines.append(question.text)
            lines += [f"  {c.value}   {c.label}{question.mark(c)}" for c in question.candidates]
        super().__init__("\n".join(lines))

    def to_record(self) -> dict[str, Any]:
        """Return the open questions as plain data."""
        questions = [{**vars(each), "candidates": [c._asdict() for c in each.candidates]} for each in self.questions]
        return {"questions": questions}
