"""The answers of a participant: a CSV file with a row for each consent and answer, on the disk before the next trial.

Rows are only appended, and the file is locked while it is open. If the program is killed or the disk is full, at most
one row lacks its last cell; that row does not count, and its trial is presented again.
"""

from __future__ import annotations

import csv
import errno
import io
import os
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from ..errors import DimpleError
from ..file_lock import lock

COLUMNS: Final = (
    "event", "time", "participant", "plan", "trial", "part", "first", "first_level", "first_s", "first_times",
    "second", "second_level", "second_s", "second_times", "answer", "answer_text", "trace", "details", "end",
)  # fmt: skip
END: Final = "."  # last cell of a complete row
Row = dict[str, str]


class Log:
    """The file of a participant's answers, created if missing; `rows` are its complete rows. The caller closes `file`.

    Raises:
        DimpleError: it cannot be read or written, is open elsewhere, or is no file of answers.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._data = path, b""
        with self._on_disk():
            self.file = path.open("a+b", buffering=0)
            try:
                self._lock()
                self.file.seek(0)
                self._data = self.file.readall()
                if (head := ",".join(COLUMNS).encode() + b"\n").startswith(self._data):
                    self._write(head[len(self._data) :])  # all of the header, or the rest of it if the disk was full
                self.rows = parsed(path, self._data)
            except BaseException:
                self.file.close()
                raise

    def append(self, row: Row) -> None:
        """Append a row and wait until it is on the disk.

        Raises:
            DimpleError: it is not on the disk, so the answer must be given again; or another program has changed the
                file, and a copy has all rows.
        """
        with self._on_disk():
            here, mine = self.path.stat() if self.path.exists() else None, os.fstat(self.file.fileno())
            if here is None or not os.path.samestat(here, mine) or here.st_size != len(self._data):
                copy = self.path.with_name(f"{self.path.stem}_kept_{time.time_ns()}.csv")
                with copy.open("xb") as file:
                    file.write(self._data + self._text(row))
                raise DimpleError(
                    "Another program has changed {path}. All answers, including this one, are in {copy}. Replace the "
                    "changed file with it, then open the experiment again.",
                    path=self.path, copy=copy.name
                )  # fmt: skip
            self._write(self._text(row))
        self.rows.append(row)

    def keep_trace(self, trial: int, rows: Iterable[Sequence[object]]) -> str:
        """Write the trace of a trial to a new file; return its path relative to the folder of the answers.

        Raises:
            DimpleError: it cannot be written.
        """
        path = self.path.with_name(f"{self.path.stem}_traces") / f"{trial:04d}_{time.time_ns()}.csv"
        with self._on_disk():
            path.parent.mkdir(exist_ok=True)
            with path.open("x", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)
                file.flush()
                os.fsync(file)
        return f"{path.parent.name}/{path.name}"

    def _lock(self) -> None:
        try:
            lock(self.file)
        except OSError:
            raise DimpleError("{path} is already open, perhaps in another Blender.", path=self.path) from None

    def _text(self, row: Row) -> bytes:
        """Return a row as bytes to append, after a line break if the file ends within a line."""
        out, cut = io.StringIO(), self._data and not self._data.endswith(b"\n")
        csv.writer(out, lineterminator="\n").writerow([row.get(name, "") for name in COLUMNS])
        return (b"\n" if cut else b"") + out.getvalue().encode()

    def _write(self, data: bytes) -> None:
        count = self.file.write(data)
        self._data += data[:count]
        if count != len(data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        os.fsync(self.file)

    @contextmanager
    def _on_disk(self) -> Iterator[None]:
        """Turn an OSError into a DimpleError with a readable message."""
        try:
            yield
        except OSError as error:
            why = error.strerror or error
            raise DimpleError("The answers cannot be kept in {path}: {error}.", path=self.path, error=why) from None


def parsed(path: Path, data: bytes) -> list[Row]:
    """Return the complete rows of a file of answers, which a spreadsheet may have saved in its own CSV dialect.

    Raises:
        DimpleError: it is no file of answers.
    """
    head, *lines = data.decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    rows = [dict(zip(COLUMNS, cells, strict=True)) for cells in map(_cells, lines) if cells]
    damaged = any(not (row["trial"] + row["answer"]).isdecimal() for row in rows if row["event"] == "answer")
    if _cells(head) != [*COLUMNS] or damaged:
        raise DimpleError("{path} is not an answer file. Choose another.", path=path)
    return rows


def _cells(line: str) -> list[str]:
    """Return the cells of a line that is a complete row or the header; none for any other line."""
    ways = (next(csv.reader([line], delimiter=mark), []) for mark in ",;\t")
    return next((row for row in ways if len(row) == len(COLUMNS) and row[-1] in (END, COLUMNS[-1])), [])
