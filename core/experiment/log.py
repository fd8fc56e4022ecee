"""The answers of a participant, a row a trial, each on the disk before the next begins.

Beside FILE.csv lies FILE_touch.csv with depth and force over time, by trial and the time of its answer. Both files only
grow. A program that is killed, or a full disk, leaves at most a row that is not finished: it is marked, and its trial
is shown again. So none is lost and none is there twice.
"""

from __future__ import annotations

import csv
import errno
import io
import os
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Final

from ..errors import DimpleError
from ..messages import Message

TOUCH: Final = ("trial", "time", "time_s", "depth_mm", "force_n")
CUT: Final = "<cut>"  # ends a row that was not finished
Sample = tuple[float, float, float]  # time [s], depth [m], force [N]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """An answer: the columns of the file. level: factor on the stiffness; test_first: 1 or 0; response: of a rating the
    step from 1 on, of a comparison 1 where the test was judged the stiffer, else 0."""

    trial: int
    plan: str
    participant: str
    time: str
    task: int
    kind: str
    condition: str
    object: str
    label: str
    level: float
    test_first: int
    response: int
    seconds: float
    force_max_n: float
    depth_max_mm: float


COLUMNS: Final = tuple(each.name for each in fields(Row))


class Log:
    """The file of a participant, made where there is none; `rows` are the answers so far.

    Args:
        path: of the CSV.
        sync: each row reaches the disk before `append` returns.

    Raises:
        DimpleError: it cannot be read or written, or is another file.
    """

    def __init__(self, path: Path, *, sync: bool = True) -> None:
        self.path, self.touch, self._sync = path, path.with_name(f"{path.stem}_touch.csv"), sync
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._begin(path, COLUMNS)
            self.rows = read_rows(path)
            self._begin(self.touch, TOUCH)
        except OSError as error:
            raise DimpleError("The answers {path} cannot be kept: {error}.", path=path, error=error) from None

    def append(self, row: Row, samples: Sequence[Sample] = ()) -> None:
        """Keep an answer, and what was touched before it.

        Raises:
            DimpleError: the disk refuses; the trial is to be shown again.
        """
        touched = [(row.trial, row.time, f"{t:.4f}", f"{1e3 * x:.4f}", f"{force:.4f}") for t, x, force in samples]
        try:
            self._write(self.touch, touched)
            self._write(self.path, [astuple(row)])
        except OSError as error:
            raise DimpleError(
                "The answer cannot be written to {path}: {error}.", path=self.path, error=error.strerror or error
            ) from None
        self.rows.append(row)

    def _begin(self, path: Path, columns: Sequence[str]) -> None:
        if not path.exists() or not path.stat().st_size:
            self._write(path, [columns])

    def _write(self, path: Path, rows: Iterable[Sequence[object]]) -> None:
        """Add rows to a file, after the mark of one that is not finished."""
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(rows)
        with path.open("a+b", buffering=0) as file:
            if size := file.seek(0, os.SEEK_END):
                file.seek(size - 1)
                if file.read() != b"\n":
                    out = io.StringIO(f"{CUT}\n{out.getvalue()}")
            data = out.getvalue().encode()
            if file.write(data) != len(data):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            if self._sync:
                os.fsync(file)


def read_rows(path: Path) -> list[Row]:
    """Return the answers in a file, without those that are not finished; the file stays as it is.

    Raises:
        OSError: it cannot be read.
        DimpleError: it is another file, or lacks a row.
    """
    head, *lines = path.read_bytes().decode("utf-8-sig", "replace").replace("\r\n", "\n").split("\n")
    if head != ",".join(COLUMNS):
        raise DimpleError("{path} is not a file of answers. Choose another.", path=path)
    whole = (line for line in lines[:-1] if not line.endswith(CUT))
    return [_row(path, number, line) for number, line in enumerate(whole, start=1)]


def _row(path: Path, number: int, line: str) -> Row:
    cells, kinds = next(csv.reader([line]), []), {"int": int, "float": float, "str": str}
    try:
        row = Row(**{each.name: kinds[str(each.type)](cell) for each, cell in zip(fields(Row), cells, strict=True)})
        if row.trial != number:
            raise ValueError(Message("it belongs to trial {trial}", trial=row.trial))
    except ValueError as error:
        raise DimpleError(
            "Row {number} of {path} is damaged, or one is missing ({error}). Repair it or choose another file.",
            number=number, path=path, error=error
        ) from None  # fmt: skip
    return row
