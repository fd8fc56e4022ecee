"""How a text table is written: its delimiter and its decimal mark."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from ..base import DimpleError
from ..messages import Message
from .question import Candidate, Question, Undecided

DELIMITERS = (",", ";", "\t", "|", " ")  # a blank stands for any run of blanks
_NUMBERLIKE = re.compile(r"^[+\-−]?[\d.,' \u00a0]*\d[\d.,' \u00a0]*([eE][+\-−]?\d+)?$")
_PLAIN = {
    ".": re.compile(r"^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$"),
    ",": re.compile(r"^[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?$"),
}
# a group of thousands never starts with 0
_GROUPED = {
    ".": re.compile(r"^[+-]?[1-9]\d{0,2}(([,' \u00a0]\d{3})+)(\.\d*)?$"),
    ",": re.compile(r"^[+-]?[1-9]\d{0,2}(([.' \u00a0]\d{3})+)(,\d*)?$"),
}
_DATE = re.compile(r"^\d{1,4}\.\d{1,2}\.\d{1,4}$")
_WITH_UNIT = re.compile(r"^([+\-−]?[\d.,]*\d(?:[eE][+\-−]?\d+)?)\s*([^\d\s].*)$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How a table is written: the delimiter of its cells and the decimal mark of its numbers."""

    delimiter: str
    decimal: str


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into cells, quotes taken off."""
    if delimiter == " ":
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def number(cell: str, decimal: str) -> float | None:
    """Return the number a cell holds, or None: text, nothing, or not a finite number."""
    text = cell.strip().replace("−", "-")
    if not text or not text[-1].isdigit() and text[-1] not in ".,":
        return None
    if _PLAIN[decimal].match(text):
        value = float(text.replace(",", "."))
    elif _GROUPED[decimal].match(text):
        other = "." if decimal == "," else ","
        value = float(re.sub(rf"[{other}' \u00a0]", "", text).replace(",", "."))
    else:
        return None
    return value if math.isfinite(value) else None


def number_and_unit(cell: str, decimal: str) -> tuple[float, str] | None:
    """Return the number and what follows it in a cell such as "12.5 gf", or None."""
    found = _WITH_UNIT.match(cell.strip())
    value = number(found[1], decimal) if found else None
    return None if value is None or found is None else (value, found[2])


def is_row(cells: Sequence[str], dialect: Dialect) -> bool:
    """Return whether cells are a row of data: two numbers or more, and no number written another way."""
    count = 0
    for cell in cells:
        if any(d in cell for d in ";\t|"):
            return False
        if number(cell, dialect.decimal) is not None or number_and_unit(cell, dialect.decimal) is not None:
            count += 1
        elif _NUMBERLIKE.match(cell) and not _DATE.match(cell):
            return False
    return count >= 2


def find_dialect(lines: Sequence[str], decimal: str | None = None) -> Dialect:
    """Find the dialect in which the most lines are rows of one width.

    Args:
        lines: of the file.
        decimal: the decimal mark where the user gave it, or None.

    Raises:
        DimpleError: no dialect makes a table of the lines.
        Undecided: the decimal mark could be either.
    """
    sample = sample_of(lines)
    scores: dict[Dialect, tuple[int, int]] = {}
    for delimiter in DELIMITERS:
        rows = [split(line, delimiter) for line in sample]
        for mark in (decimal,) if decimal else (".", ","):
            if mark == delimiter and not any("," in cell for row in rows for cell in row):
                continue  # decimal commas between commas need quotes
            dialect = Dialect(delimiter=delimiter, decimal=mark)
            good = [row for row in rows if is_row(row, dialect)]
            width = Counter(len(row) for row in good).most_common(1)
            if width and width[0][1] >= 3:
                numbers = sum(number(cell, mark) is not None for row in good for cell in row)
                scores[dialect] = (width[0][1], numbers)
    if not scores:
        raise DimpleError(
            "There is no table in this file: no run of rows with two or more numbers. "
            "It must have a column of depth and a column of force."
        )
    best = max(scores, key=lambda dialect: scores[dialect])
    rival = Dialect(delimiter=best.delimiter, decimal="." if best.decimal == "," else ",")
    if scores.get(rival) == scores[best]:
        _ask_decimal([split(line, best.delimiter) for line in sample], best)
    return best


def sample_of(lines: Sequence[str]) -> list[str]:
    """Return lines from the beginning, the middle and the end that are not blank."""
    if len(lines) <= 900:
        picked = list(lines)
    else:
        middle = len(lines) // 2
        picked = [*lines[:500], *lines[middle : middle + 200], *lines[-200:]]
    return [line for line in picked if line.strip()]


def _ask_decimal(rows: Sequence[Sequence[str]], best: Dialect) -> None:
    for row in rows:
        for cell in row:
            points, commas = number(cell, "."), number(cell, ",")
            if is_row(row, best) and points is not None and commas is not None and points != commas:
                raise Undecided(
                    Question(
                        name="decimal",
                        text=Message("In “{cell}”, does the mark separate thousands or decimals?", cell=cell),
                        candidates=(
                            Candidate(value=".", label=f"{cell} = {points:g}"),
                            Candidate(value=",", label=f"{cell} = {commas:g}"),
                        ),
                    )
                )
