"""What a file leaves open, and what the user answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..base import DimpleError


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
    cycle: which of several presses, counted from 1.
    contact_mm: reading of the depth at first touch [mm].
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
    """A possible answer: its value, and what it means, with a preview of the data."""

    value: str
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """A question about one field of Answers.

    name: the field.
    text: the question as a sentence.
    candidates: the answers that are possible.
    """

    name: str
    text: str
    candidates: tuple[Candidate, ...]


class Undecided(DimpleError):
    """A file can be read in several ways; `questions` ask which is right."""

    def __init__(self, *questions: Question) -> None:
        self.questions = questions
        lines = []
        for question in questions:
            lines.append(question.text)
            lines += [f"  {c.value}   {c.label}" for c in question.candidates]
        super().__init__("\n".join(lines))

    def to_record(self) -> dict[str, Any]:
        """Return the open questions as plain data."""
        return {
            "questions": [
                {
                    "name": question.name, "text": question.text,
                    "candidates": [{"value": c.value, "label": c.label} for c in question.candidates],
                }
                for question in self.questions
            ]
        }  # fmt: skip


class WrongColumns(DimpleError):
    """The columns that were taken hold no press; the fields of Answers in `answers` choose others."""

    answers = ("depth_column", "force_column")
