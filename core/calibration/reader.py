"""From an instrument's file to its measurement; nothing here unpacks, waits or grows without bound."""

from __future__ import annotations

import stat
from dataclasses import replace
from pathlib import Path

from ..base import DimpleError
from ..messages import Message
from .columns import Measurement, measurement_of
from .dialect import find_dialect
from .question import Answers
from .table import find_table
from .vocabulary import role_of, split_unit

MAX_BYTES = 64 * 2**20  # a million rows: far more than an instrument writes
MAX_LINE = 20_000  # characters
_NARROW = dict.fromkeys(map(ord, "\u2009\u202f\u2007"), "\u00a0")  # spaces between groups of thousands
_SNIFFED = 64 * 2**10  # bytes looked at to tell encodings apart
# how other files begin: what they are
_MAGIC = {
    b"PK\x03\x04": "a ZIP archive (an Excel or LibreOffice sheet is one too)",
    b"PK\x05\x06": "an empty ZIP archive",
    b"\xd0\xcf\x11\xe0": "an old Excel or Word file",
    b"\x1f\x8b": "a gzip archive",
    b"BZh": "a bzip2 archive",
    b"\xfd7zXZ": "an xz archive",
    b"7z\xbc\xaf": "a 7-Zip archive",
    b"(\xb5/\xfd": "a zstd archive (a .blend file may be one)",
    b"BLENDER": "a Blender file",
    b"MATLAB": "a MATLAB file",
    b"\x89HDF": "a MATLAB or HDF5 file",
    b"%PDF": "a PDF",
    b"\x89PNG": "a picture",
    b"\xff\xd8\xff": "a picture",
    b"GIF8": "a picture",
}
_MARKS = ((b"\xff\xfe\x00\x00", "utf-32"), (b"\x00\x00\xfe\xff", "utf-32"), (b"\xef\xbb\xbf", "utf-8-sig"),
          (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))  # fmt: skip


def read_measurement(path: str | Path, answers: Answers | None = None) -> Measurement:
    """Read a force-depth file.

    Args:
        answers: of the user to earlier questions.

    Raises:
        Undecided: the file can be read in several ways; its questions say which.
        DimpleError: the file is not a force-depth table, or beyond the limits.
    """
    answers = answers or Answers()
    lines, encoding, notes = load_lines(path)
    table = find_table(lines, find_dialect(lines, answers.decimal), answers)
    if encoding not in ("utf-8", "utf-8-sig"):
        notes += (Message("The text was read as {encoding}.", encoding=encoding),)
    found = measurement_of(table, answers)
    return replace(found, source=Path(path).name, notes=(*notes, *found.notes))


def load_lines(path: str | Path) -> tuple[list[str], str, tuple[str, ...]]:
    """Read a text file.

    Returns:
        its lines, the encoding they were written in, and notes.

    Raises:
        DimpleError: the file is missing, not a text table, or beyond the limits.
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
            "Line {line} has {lines:,} characters; a row of a table has at most {most:,}. This is not a force-depth "
            "table, or its line ends are lost: export it again.",
            line=longest + 1,
            lines=len(lines[longest]),
            most=MAX_LINE,
        )
    notes: tuple[str, ...] = ()
    if text[-1] not in "\n\r\x1a" and len(lines) > 20 and _looks_cut(lines):
        lines.pop()
        notes = ("The last line breaks off and was left out.",)
    return lines, encoding, notes


def decode(data: bytes) -> tuple[str, str]:
    """Turn bytes into text; what is not Unicode is read by the code page that yields more names of columns."""
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data.decode(encoding, errors="replace"), encoding
    sample = data[:_SNIFFED]
    if b"\x00" in sample:
        zeros = (sample[0::2].count(0), sample[1::2].count(0))
        if max(zeros) > 0.6 * len(sample) / 2 and min(zeros) < 0.1 * len(sample) / 2:
            encoding = "utf-16-be" if zeros[0] > zeros[1] else "utf-16-le"
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
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise DimpleError("{name} is not a file.", name=path.name)
        if status.st_size <= MAX_BYTES:
            with path.open("rb") as file:
                data = file.read(MAX_BYTES + 1)
            if len(data) <= MAX_BYTES:
                return data
    except OSError as error:
        raise DimpleError("{name} cannot be read: {error}.", name=path.name, error=error.strerror or error) from None
    raise DimpleError(
        "{name} is larger than {size} MB, the most a measurement may have. Export one test, or fewer samples a second.",
        name=path.name,
        size=MAX_BYTES // 2**20,
    )


def _looks_cut(lines: list[str]) -> bool:
    """Return whether the last of the lines is shorter than those before it ever are in its digits or cells."""
    last, before = lines[-1], lines[-20:-1]
    shapes = [(line.count(","), line.count(";"), line.count("\t"), len(line.split())) for line in before]
    shape = (last.count(","), last.count(";"), last.count("\t"), len(last.split()))
    return shape not in shapes or len(last) < min(map(len, before))


def _names(text: str) -> int:
    """Return how many cells near the beginning of a text are the names of columns."""
    near = text[:_SNIFFED].split("\n")[:200]
    return sum(role_of(split_unit(cell)[0]) is not None for line in near for cell in _cells(line))


def _cells(line: str) -> list[str]:
    for delimiter in ";\t,=":
        line = line.replace(delimiter, "\n")
    return [cell.strip(' "') for cell in line.split("\n") if any(c.isalpha() for c in cell)]
