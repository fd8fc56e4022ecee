"""What a file leaves open, and what the user answers."""

from __future__ import annotations

from dataclasses import dataclass

from ..base import DimpleError


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """Hold what the user has said about a file; None is "find out, and ask where that fails".

    depth_column, force_column: a header, or a number counted from 1.  depth_unit, force_unit: "mm", "gf"...
    decimal: "." or ",".  table: of several in the file, counted from 1.  press: "positive" or "negative", the sign of
    a pressing force.  cycle: of several presses, counted from 1.  contact_mm: reading of the depth at first touch.
    """

    depth_column: str | None = None
    force_column: str | None = None
    depth_unit: str | None = None
    force_unit: str | None = None
    decimal: str | None = None
    table: int | None = None
    press: str | None = None
    cycle: int | None = None
    contact_mm: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """Offer an answer: its value, and what it means with a preview of the data."""

    value: str
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """Ask for one field of Answers; `option` is what answers it on the command line."""

    name: str
    text: str
    candidates: tuple[Candidate, ...]

    @property
    def option(self) -> str:
        return "--" + self.name.replace("_", "-")


class Undecided(DimpleError):
    """Say that a file can be read in several ways, and ask which is right."""

    def __init__(self, *questions: Question) -> None:
        self.questions = questions
        lines = []
        for question in questions:
            lines.append(f"{question.text} Answer with {question.option}:")
            lines += [f"  {question.option} {c.value}   {c.label}" for c in question.candidates]
        super().__init__("\n".join(lines))
