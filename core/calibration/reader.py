"""From a file to lines and cells of text; no input makes it decompress, block, or use unbounded memory."""

from __future__ import annotations

import csv
import math
import re
import stat
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..base import DimpleError
from ..message import Message
from .known_words_and_units import role_of, split_unit
from .question import Question, Remarks, Undecided

MAX_BYTES = 64 * 2**20  # [bytes] largest file: a million rows, far more than an instrument writes
MAX_LINE = 20_000  # [characters] longest line
_NARROW = dict.fromkeys(map(ord, "\u2009\u202f\u2007"), "\u00a0")  # spaces between groups of thousands
# first bytes of files that people mistake for tables: kind of file
_MAGIC = {
    b"PK\x03\x04": "a spreadsheet or a ZIP archive",
    b"\xd0\xcf\x11\xe0": "an old Excel or Word file",
    b"MATLAB": "a MATLAB file",
    b"\x89HDF": "a MATLAB or HDF5 file",
    b"%PDF": "a PDF",
}
_MARKS = ((b"\xff\xfe\x00\x00", "utf-32"), (b"\x00\x00\xfe\xff", "utf-32"), (b"\xef\xbb\xbf", "utf-8-sig"),
          (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))  # fmt: skip
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


def load_lines(path: str | Path, remarks: Remarks) -> list[str]:
    """Return the lines of a text file.

    Raises:
        DimpleError: the file is missing, not a text table, or exceeds the limits.
    """
    data = _read(Path(path))
    for magic, kind in _MAGIC.items():
        if data.startswith(magic):
            raise DimpleError(
                "This is {kind}, not a text table. Export the measurement as CSV and open that.", kind=Message(kind)
            )
    if not data.strip():
        raise DimpleError("The file is empty. Export the measurement again.")
    text, encoding = decode(data)
    text = text.translate(_NARROW)
    bad = sum(text.count(chr(c)) for c in range(32) if chr(c) not in "\t\n\r\f\x1a")
    if bad > 0.001 * len(text) + 2 or "\x00" in text:
        raise DimpleError("The file holds binary data, not a text table. Export the measurement as CSV and open that.")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\x1a\n").split("\n")
    longest = max(range(len(lines)), key=lambda i: len(lines[i]))
    if len(lines[longest]) > MAX_LINE:
        raise DimpleError(
            "Line {line} has {lines:,} characters, but a row of a table has at most {most:,}. Either this is not a "
            "force-depth table, or its line breaks are lost: export it again.",
            line=longest + 1,
            lines=len(lines[longest]),
            most=MAX_LINE,
        )
    if encoding not in ("utf-8", "utf-8-sig"):
        remarks.note("The text was read as {encoding}.", encoding=encoding)
    return lines


def decode(data: bytes) -> tuple[str, str]:
    """Return text and encoding of bytes; if not Unicode, use the code page that yields more known column names."""
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data.decode(encoding, errors="replace"), encoding
    try:
        return data.decode("utf-8"), "utf-8"
    except UnicodeDecodeError as error:
        if error.start >= len(data) - 3:  # cut within a character
            return data[: error.start].decode("utf-8"), "utf-8"
    western, japanese = (data.decode(encoding, errors="replace") for encoding in ("cp1252", "cp932"))
    return (japanese, "cp932") if _names(japanese) > _names(western) else (western, "cp1252")


def _read(path: Path) -> bytes:
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise DimpleError("{name} is not a file.", name=path.name)
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise DimpleError("{name} cannot be read: {error}.", name=path.name, error=error.strerror or error) from None
    if len(data) > MAX_BYTES:
        raise DimpleError(
            "{name} is larger than {size} MB, the largest size for a measurement. Export a single test, or fewer "
            "samples per second.",
            name=path.name,
            size=MAX_BYTES // 2**20,
        )
    return data


def _names(text: str) -> int:
    """Return the number of known column names among the cells at the beginning of a text."""
    cells = (cell.strip(' "') for line in text.split("\n", 200)[:200] for cell in re.split(r"[;\t,=]", line))
    return sum(role_of(split_unit(cell)[0]) is not None for cell in cells if any(c.isalpha() for c in cell))


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """The format of a table: the delimiter of its cells and the decimal mark of its numbers."""

    delimiter: str
    decimal: str


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into cells, without their quotes."""
    if delimiter == " ":
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def number(cell: str, decimal: str) -> float | None:
    """Return the number in a cell, None if it is text, empty, or not a finite number."""
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
    """Return the number in a cell and the text after it, as in "12.5 gf", or None."""
    if (plain := number(cell, decimal)) is not None:
        return plain, ""
    found = _WITH_UNIT.match(cell.strip())
    value = number(found[1], decimal) if found else None
    return None if value is None or found is None else (value, found[2])


def is_row(cells: Sequence[str], dialect: Dialect) -> bool:
    """Return whether cells are a row of data: at least two numbers, and none in another notation."""
    count = 0
    for cell in cells:
        if any(d in cell for d in ";\t|"):
            return False
        if number_and_unit(cell, dialect.decimal) is not None:
            count += 1
        elif _NUMBERLIKE.match(cell) and not _DATE.match(cell):
            return False
    return count >= 2


def pairs(text: str) -> list[tuple[float, float]]:
    """Return the first two numbers, with or without units, of each row of a text copied from a spreadsheet.

    Raises:
        DimpleError: there are no such rows, or the decimal mark is ambiguous.
    """
    lines = text.splitlines()
    try:
        dialect = find_dialect(lines)
    except Undecided:
        raise DimpleError("1.000 could mean one or a thousand. Copy the numbers with fewer decimals.") from None
    rows = [cells for line in lines if is_row(cells := split(line, dialect.delimiter), dialect)]
    if not rows:
        raise DimpleError("The copied text has no rows of two numbers: depth and grams.")
    found = [[pair[0] for cell in cells if (pair := number_and_unit(cell, dialect.decimal))] for cells in rows]
    return [(values[0], values[1]) for values in found]


def find_dialect(lines: Sequence[str], decimal: str | None = None) -> Dialect:
    """Find the dialect in which the most lines are rows of equal width.

    Args:
        lines: the lines of the file.
        decimal: the decimal mark if the user gave it, or None.

    Raises:
        DimpleError: the lines are a table in no dialect.
        Undecided: the decimal mark is ambiguous.
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
            "This file has no table, that is, no block of rows with two or more numbers. It must have a column of "
            "depth and a column of force."
        )
    best = max(scores, key=lambda dialect: scores[dialect])
    rival = Dialect(delimiter=best.delimiter, decimal="." if best.decimal == "," else ",")
    if scores.get(rival) == scores[best]:
        _ask_decimal([split(line, best.delimiter) for line in sample], best)
    return best


def sample_of(lines: Sequence[str]) -> list[str]:
    """Return the non-blank lines among some from the beginning, the middle and the end."""
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
                text = Message("In “{cell}”, does the mark separate thousands or decimals?", cell=cell)
                either = (".", f"{cell} = {points:g}"), (",", f"{cell} = {commas:g}")
                raise Undecided(Question("decimal", text, *either))
