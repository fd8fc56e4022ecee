"""From lines to a table: where it begins and ends, the names and units of its columns, and their numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base import DimpleError, Floats
from ..message import Message
from .known_words_and_units import is_known, role_of, split_unit, unit_of
from .question import Answers, Question, Remarks, Undecided
from .reader import Dialect, is_row, number_and_unit, split

MAX_ROWS = 100_000  # rows kept of a table, far more than a fit needs; of a larger table, every n-th row
MIN_ROWS = 8  # smallest number of rows: two for each piece of the law, one each for touch and tare, two to spare
SLIGHT = 0.01  # share of a range: the error of instruments
_NOTHING = frozenset(("", "-", "--", "---", "----", "nan", "n/a", "na", "null", "none"))  # cells that mean "no value"


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of text and numbers with n rows and c columns.

    names: (c,) name of each column, "" if it has none.
    units: (c,) unit of each column as written, "" if it has none.
    numbers: (n, c) values, NaN for a cell without a number.
    numeric: indices of the columns that hold numbers.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    numbers: Floats
    numeric: tuple[int, ...]

    def title(self, at: int) -> str:
        """Return the title of a column in a question: its name and unit, or its number."""
        return title_of(self.names[at], self.units[at], at)

    def role(self, at: int) -> str | None:
        """Return the role of a column by its name, see `role_of`."""
        return role_of(self.names[at])

    def kind(self, at: int) -> str | None:
        """Return the kind of the unit of a column, see `unit_of`."""
        found = unit_of(self.units[at])
        return found[0] if found else None


def title_of(name: str, unit: str, at: int) -> str:
    """Return the title of a column: its name with its unit, if any, or its number if it has no name."""
    return (name + (f" ({unit})" if unit else "")) if name else Message("column {number}", number=at + 1)


def find_table(lines: Sequence[str], dialect: Dialect, answers: Answers, remarks: Remarks) -> Table:
    """Find the table; of several, the one that the user chose.

    Raises:
        DimpleError: too few rows.
        Undecided: several tables, and no choice.
    """
    runs = _find_runs(lines, dialect)
    if len(runs) > 1 and answers.table is None:
        raise Undecided(_which_table(lines, runs))
    chosen = 0 if answers.table is None else answers.table - 1
    if not 0 <= chosen < len(runs):
        raise DimpleError(
            "There is no table {table} in this file: it has {tables}.", table=chosen + 1, tables=len(runs)
        )
    above = lines[runs[chosen - 1].end if chosen else 0 : runs[chosen].start]
    return _table(runs[chosen].lines, above, dialect, remarks)


@dataclass(slots=True)
class _Run:
    """A run of rows, which may have other lines in between.

    start, end: index of its first line, and of the line after its last.
    header: the lines above it that name its columns.
    lines: all lines of the run.
    """

    start: int
    end: int
    header: list[str]
    lines: list[str]


def _find_runs(lines: Sequence[str], dialect: Dialect) -> list[_Run]:
    """Return the runs of rows long enough for a fit, else the first run; runs with equal headers (pages) are joined."""
    runs: list[_Run] = []
    header: list[str] = []
    open_run: _Run | None = None
    for i, line in enumerate(lines):
        if open_run and line[:1].isdigit() and open_run.end == i and len(lines) > MAX_ROWS:
            open_run.end = i + 1  # in a huge file, accept a line that begins with a digit without parsing it here
        elif is_row(cells := split(line, dialect.delimiter), dialect):
            if open_run is None:
                open_run = _Run(i, i, header, [])
                runs.append(open_run)
                header = []
            open_run.end = i + 1
        elif line.strip() and _is_header(cells):
            header.append(line.strip())
            open_run = None
    for run in runs:
        run.lines = [*lines[run.start : run.end]]
    first = runs[:1]
    for run in runs[1:]:
        same = next((one for one in first if one.header and one.header[-len(run.header) :] == run.header), None)
        if same:
            same.lines += run.lines
        else:
            first.append(run)
    return [run for run in first if len(run.lines) >= MIN_ROWS] or first[:1]


def _is_header(cells: Sequence[str]) -> bool:
    named = [cell for cell in cells if cell and any(c.isalpha() for c in cell)]
    return len(named) >= 2 and sum(map(is_known, named)) >= 2


def _which_table(lines: Sequence[str], runs: Sequence[_Run]) -> Question:
    """Return the question which of several tables is the measurement."""

    def label(run: _Run) -> str:
        above = next((lines[i].strip() for i in range(run.start - 1, -1, -1) if lines[i].strip()), "")
        return Message("lines {start} to {end}, under “{above}”", start=run.start + 1, end=run.end, above=above[:60])

    text = Message("The file holds {tables} tables. Which one is the measurement?", tables=len(runs))
    return Question("table", text, *((str(i + 1), label(run)) for i, run in enumerate(runs)))


def _table(lines: Sequence[str], above: Sequence[str], dialect: Dialect, remarks: Remarks) -> Table:
    stride = -(-len(lines) // MAX_ROWS)
    if stride > 1:
        remarks.note("One in {stride} of the {lines:,} rows was read.", lines=len(lines), stride=stride)
        lines = lines[::stride]
    rows = [split(line, dialect.delimiter) for line in lines if line.strip()]
    widths = Counter(map(len, rows))
    # the widest rows that are many: of tests side by side some end earlier
    width = max((each for each in widths if widths[each] >= MIN_ROWS), default=0)
    whole = [row + [""] * (width - len(row)) for row in rows if len(row) <= width and widths[len(row)] >= MIN_ROWS]
    if len(whole) < len(rows):
        say, count = remarks.warn if len(whole) < 0.95 * len(rows) else remarks.note, len(rows) - len(whole)
        say("{count} of {rows} rows have a different number of cells and were left out.", count=count, rows=len(rows))
    if len(whole) < MIN_ROWS:
        raise DimpleError("The table has {rows} rows; a fit needs at least {least}.", rows=len(whole), least=MIN_ROWS)
    columns = list(zip(*whole, strict=True))
    while columns and not any(columns[-1]):  # a delimiter at the end of every row
        columns.pop()
    numbers, cell_units = zip(*(_column(column, dialect.decimal) for column in columns), strict=True)
    names, header_units = _header(above, len(columns), dialect)
    units = [in_cell or in_header for in_cell, in_header in zip(cell_units, header_units, strict=True)]
    numeric = [i for i, column in enumerate(columns) if _is_numeric(column, numbers[i])]
    for i in numeric:
        beside = columns[i + 1] if i + 1 < len(columns) and i + 1 not in numeric and not units[i] else ()
        cells = set(beside) - {""}
        kinds = {found and found[0] for found in map(unit_of, cells)}
        if len(kinds) != 1 or None in kinds:
            continue
        if len(cells) > 1:
            raise DimpleError(
                "The unit of {title} changes within the file. Convert it to one unit first.",
                title=title_of(names[i], "", i),
            )
        (units[i],) = cells
    listed = _listed_units(above)
    if len(listed) == len(numeric) and not any(units[i] for i in numeric):
        for i, unit in zip(numeric, listed, strict=True):
            units[i] = unit
    return Table(names=names, units=tuple(units), numbers=np.stack(numbers, axis=1), numeric=tuple(numeric))


def _listed_units(above: Sequence[str]) -> list[str]:
    """Return the units in a line such as "UNIT = gf,mm" above a table."""
    for line in above:
        found = re.match(r"\W*(?:units?|einheit|単位)\s*[=:;,\t]\s*(.+)", line, re.IGNORECASE)
        listed = [word for word in re.split(r"[,;\s]+", found[1]) if word] if found else []
        if listed and all(map(unit_of, listed)):
            return listed
    return []


def _is_numeric(cells: Sequence[str], numbers: Floats) -> bool:
    """Return whether a column is numeric: most cells are numbers, or MIN_ROWS cells and most of those not empty."""
    count, filled = int(np.isfinite(numbers).sum()), sum(cell.strip().lower() not in _NOTHING for cell in cells)
    return count > 0.5 * len(cells) or (count >= MIN_ROWS and count > 0.5 * filled)


def _column(cells: Sequence[str], decimal: str) -> tuple[Floats, str]:
    """Return the numbers of a column, NaN for cells without one, and the unit in its cells ("12.5 gf"), if any."""
    pairs = [number_and_unit(cell, decimal) for cell in cells]
    carried = Counter(pair[1] for pair in pairs if pair)
    unit = next((unit for unit in carried if carried[unit] > len(cells) / 2 and unit_of(unit)), "")
    return np.array([pair[0] if pair and pair[1] == unit else np.nan for pair in pairs]), unit


def _header(above: Sequence[str], width: int, dialect: Dialect) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the columns and their units from the lines above a table."""
    names, units = [""] * width, [""] * width
    near = [line for line in above if line.strip() and "=" not in line]
    for line in reversed(near):
        cells = _fitted(line, width, dialect)
        filled = [cell for cell in cells if cell]
        if filled and not any(units) and not any(names) and _are_units(filled):
            units = cells
        elif len(filled) >= 2 and any(role_of(split_unit(cell)[0]) for cell in filled):
            names = cells
            break
        elif len(filled) >= max(2, width - 1) and not any(names):
            names = cells  # unknown words: keep them for display
    parted = [split_unit(name) for name in names]
    both = [(name, unit or in_name) for unit, (name, in_name) in zip(units, parted, strict=True)]
    return tuple(name for name, _ in both), tuple(unit for _, unit in both)


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether cells are a row of units; one short word may be an unknown unit."""
    unknown = [cell for cell in cells if not unit_of(cell)]
    bare = all(len(cell) <= 8 and not role_of(cell) for cell in unknown)
    return not unknown or (len(unknown) == 1 and bare)


def _fitted(line: str, width: int, dialect: Dialect) -> list[str]:
    """Split a header line into as many cells as the table has columns; all are empty if it does not fit."""
    text = line.strip().lstrip("#%").strip() if dialect.delimiter == " " else line.lstrip("#% ")
    cells = split(text, dialect.delimiter)
    if dialect.delimiter == " " and len(cells) != width:
        cells = re.split(r"\s{2,}|\t", text)
    if len(cells) > width + 1 and any(cells[width:]):
        named, stray = ([role_of(split_unit(cell)[0]) for cell in part] for part in (cells[:width], cells[width:]))
        beside = {"depth", "force"} <= set(named) and not {"depth", "force"} & set(stray)  # notes beside a header
        return cells[:width] if beside else [""] * width
    if len(cells) < width:  # R leaves out the name of the first column, others that of the last: ambiguous
        return [""] * width
    return cells[:width]
