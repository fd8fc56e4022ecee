"""The answers of a participant, a row a trial, each on the disk before the next begins.

Beside FILE.csv lies FILE_touch.csv with depth and force over time. A program that is killed leaves at most a row that
is not finished: that is dropped, and its trial is shown again. So none is lost and none is there twice.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ..errors import DimpleError

COLUMNS: Final = (
    "trial", "plan", "participant", "time", "task", "kind", "condition", "object", "label", "level", "test_first",
    "response", "seconds", "force_max_n", "depth_max_mm",
)  # fmt: skip
TOUCH: Final = ("trial", "time_s", "depth_mm", "force_n")
Sample = tuple[float, float, float]  # time [s], depth [m], force [N]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """An answer: the columns of the file. level: factor on the stiffness; response: of a rating the step from 1 on,
    of a comparison 1 where the test was judged the stiffer, else 0."""

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
    test_first: bool
    response: int
    seconds: float
    force_max_n: float
    depth_max_mm: float


class Log:
    """The file of a participant.

    Args:
        path: of the CSV; made where there is none.
        sync: each row reaches the disk before `append` returns.

    Attributes:
        rows: the answers so far.

    Raises:
        DimpleError: it cannot be read or written, or is another file.
    """

    def __init__(self, path: Path, *, sync: bool = True) -> None:
        self.path, self.touch, self._sync = path, path.with_name(f"{path.stem}_touch.csv"), sync
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self.rows = self._resume()
        except (OSError, UnicodeDecodeError) as error:
            raise DimpleError("The answers {path} cannot be kept: {error}.", path=path, error=error) from None

    def append(self, row: Row, samples: Sequence[Sample] = ()) -> None:
        """Keep an answer, and what was touched before it.

        Raises:
            DimpleError: the disk refuses; the trial is to be shown again.
        """
        lines = [(row.trial, f"{t:.4f}", f"{1e3 * depth:.4f}", f"{force:.4f}") for t, depth, force in samples]
        try:
            self._write(self.touch, lines)
            self._write(self.path, [[_cell(getattr(row, name)) for name in COLUMNS]])
        except OSError as error:
            raise DimpleError(
                "The answer cannot be written to {path}: {error}.", path=self.path, error=error.strerror
            ) from None
        self.rows.append(row)

    def _resume(self) -> list[Row]:
        """Return the rows that are whole; cut off what is not."""
        rows = []
        if self._whole(self.path, COLUMNS):
            text = self.path.read_text(encoding="utf-8")
            for number, cells in enumerate(csv.DictReader(io.StringIO(text)), start=1):
                rows.append(_row(self.path, number, cells))
        kept = len(rows)
        if self._whole(self.touch, TOUCH):
            lines = self.touch.read_text(encoding="utf-8").splitlines(keepends=True)
            whole = [line for line in lines[1:] if int(line.partition(",")[0]) <= kept]
            if len(whole) < len(lines) - 1:  # of a trial that was not answered
                _replace(self.touch, "".join([lines[0], *whole]))
        return rows

    def _whole(self, path: Path, columns: Sequence[str]) -> bool:
        """Tell whether a file has rows; make it where there is none, cut off a row that is not finished."""
        head = ",".join(columns) + "\n"
        data = path.read_bytes() if path.exists() else b""
        if not data.endswith(b"\n"):
            data = data[: data.rfind(b"\n") + 1]
            _replace(path, data.decode() or head)
        if data and not data.startswith(head.encode()):
            raise DimpleError("{path} is not a file of answers. Choose another.", path=path)
        return bool(data)

    def _write(self, path: Path, rows: Sequence[Sequence[object]]) -> None:
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(rows)
        handle = os.open(path, os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0))
        try:
            os.write(handle, out.getvalue().encode())
            if self._sync:
                os.fsync(handle)
        finally:
            os.close(handle)


def _replace(path: Path, text: str) -> None:
    """Write a file so that there is always a whole one."""
    beside = path.with_suffix(".part")
    beside.write_text(text, encoding="utf-8", newline="")
    os.replace(beside, path)


def _cell(value: object) -> object:
    return int(value) if isinstance(value, bool) else value


def _row(path: Path, number: int, cells: dict[str, str]) -> Row:
    try:
        row = Row(
            trial=int(cells["trial"]), plan=cells["plan"], participant=cells["participant"], time=cells["time"],
            task=int(cells["task"]), kind=cells["kind"], condition=cells["condition"], object=cells["object"],
            label=cells["label"], level=float(cells["level"]), test_first=cells["test_first"] == "1",
            response=int(cells["response"]), seconds=float(cells["seconds"]),
            force_max_n=float(cells["force_max_n"]), depth_max_mm=float(cells["depth_max_mm"]),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError) as error:
        raise DimpleError(
            "Row {number} of {path} is damaged ({error}). Repair it or choose another file.",
            number=number, path=path, error=error
        ) from None  # fmt: skip
    if row.trial != number:
        raise DimpleError(
            "Row {number} of {path} belongs to trial {trial}: a row is missing or repeated. Repair the file or "
            "choose another one.",
            number=number, path=path, trial=row.trial
        )  # fmt: skip
    return row
