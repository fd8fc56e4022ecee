"""Read an instrument's file. Encoding, delimiters, headers and units are detected, or asked where they cannot be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .blocks import MIN_ROWS
from .dialect import find_dialect
from .load import load_lines
from .question import Answers
from .roles import find_columns
from .table import find_table


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """A force-depth table as the instrument wrote it, in its own zero and sign.

    source: name of the file.
    depth: (n,) [m].
    force: (n,) [N].
    depth_header: of the column the depth is from.
    force_header: of the column the force is from.
    columns: numbers of both columns, counted from 1.
    units: of depth and force, as they were taken.
    timed: a clock or a count of rows says that the rows stand in the order they were measured.
    notes: messages about how the file was read.
    warnings: messages about what may be wrong.
    """

    source: str
    depth: Floats
    force: Floats
    depth_header: str
    force_header: str
    columns: tuple[int, int] = (1, 2)
    units: tuple[str, str] = ("m", "N")
    timed: bool = False
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


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
    columns = find_columns(table, answers)
    if encoding not in ("utf-8", "utf-8-sig"):
        notes += (Message("The text was read as {encoding}.", encoding=encoding),)
    measurement = Measurement(
        source=Path(path).name, depth=columns.depth, force=columns.force,
        depth_header=columns.depth_header, force_header=columns.force_header, columns=columns.numbers,
        units=columns.units, timed=columns.timed,
        notes=(*notes, *table.notes, *columns.notes), warnings=table.warnings,
    )  # fmt: skip
    return _whole_rows(measurement)


def _whole_rows(measurement: Measurement) -> Measurement:
    """Leave out the rows without a depth or a force."""
    whole = np.isfinite(measurement.depth) & np.isfinite(measurement.force)
    missing, n = int((~whole).sum()), len(whole)
    if n - missing < MIN_ROWS:
        raise DimpleError(
            "Only {n} rows have both a depth and a force; a fit needs at least {least}.", n=n - missing, least=MIN_ROWS
        )
    if not missing:
        return measurement
    text = Message("{missing} of {n} rows have no depth or no force and were left out.", missing=missing, n=n)
    serious = missing > 0.05 * n and not whole[: n - missing].all()  # beside a longer test a column just ends
    return replace(
        measurement,
        depth=measurement.depth[whole],
        force=measurement.force[whole],
        notes=measurement.notes if serious else (*measurement.notes, text),
        warnings=(*measurement.warnings, text) if serious else measurement.warnings,
    )
