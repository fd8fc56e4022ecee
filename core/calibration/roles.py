"""Which column is the depth, which the force, and in what units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message, in_a_row
from .blocks import MIN_ROWS
from .question import Answers, Candidate, Question, Undecided
from .table import Table
from .units import KIND, Unit, factor_to_si, kind_of, title_of, which_unit, written_units
from .vocabulary import role_of

_COUNT = re.compile(r"(no|nr|number|index|sample|row|point|#|番号|no\.|nr\.)", re.IGNORECASE)
_SAME = 0.01  # of the range: columns nearer than this say the same
_BACKWARD = 0.02  # of the rows: a clock may start again with each cycle, no more


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """The columns of depth and force.

    depth: (n,) [m], NaN where a cell is no number.
    force: (n,) [N], NaN where a cell is no number.
    depth_header: of the column.
    force_header: of the column.
    numbers: of both columns, counted from 1.
    units: of both columns, as they were taken.
    timed: a clock or a count of rows runs beside them, so that their order is known.
    notes: messages about how they were read.
    """

    depth: Floats
    force: Floats
    depth_header: str
    force_header: str
    numbers: tuple[int, int]
    units: tuple[str, str]
    timed: bool
    notes: tuple[str, ...]


def find_columns(table: Table, answers: Answers) -> Columns:
    """Choose and convert the columns.

    Raises:
        Undecided: a column or a unit could be several, with all that is open at once.
        DimpleError: there is nothing to choose from, or an answer names nothing.
    """
    units = written_units(table)
    notes: list[str] = []
    table, timed = _in_time(table, units, notes)
    questions: list[Question] = []
    named = {"depth": answers.depth_column, "force": answers.force_column}
    given = {role: _named(table, name, role) for role, name in named.items() if name is not None}
    chosen: dict[str, int | None] = dict(given)

    def left(columns: Sequence[int]) -> list[int]:
        return [i for i in columns if i not in given.values()]

    for role in ("depth", "force"):
        if role in given:
            continue
        options = left(_options(table, units, role))
        if not options and any(table.names):
            options = left(_unnamed(table, units))
        if len(options) > 1 and (beside := _beside(table, units, role, options, given)) is not None:
            notes.append(Message(
                "{title} was taken, column {number}, of the same test.",
                title=title_of(table, beside), number=beside + 1
            ))  # fmt: skip
            options = [beside]
        if len(options) > 1 and _alike(table.numbers[:, options]):
            notes.append(Message(
                "{title} was taken; {other} says the same.",
                title=title_of(table, options[0]), other=title_of(table, options[1])
            ))  # fmt: skip
            options = options[:1]
        chosen[role] = options[0] if len(options) == 1 and role_of(table.names[options[0]]) == role else None
        if chosen[role] is None and len(options) == 1 and kind_of(units[options[0]]) == KIND[role]:
            chosen[role] = options[0]
        if chosen[role] is None:
            questions.append(_which_column(table, role, options or left(_unnamed(table, units))))
    _check_distinct(table, chosen, questions, bool(given) or not any(table.names))
    factors: dict[str, tuple[Floats | float, str]] = {}
    for role in ("depth", "force"):
        factor = factor_to_si(table, units, chosen[role], role, getattr(answers, f"{role}_unit"), notes)
        if factor is None:
            questions.append(which_unit(table, role, chosen[role]))
        else:
            factors[role] = factor
    if questions:
        raise Undecided(*questions)
    depth_at, force_at = chosen["depth"], chosen["force"]
    assert depth_at is not None and force_at is not None
    time_at = _time_column(table, units)
    if time_at is not None and answers.depth_column is None and answers.force_column is None:
        _check_clock(table, time_at, depth_at)
    return Columns(
        depth=table.numbers[:, depth_at] * factors["depth"][0],
        force=table.numbers[:, force_at] * factors["force"][0],
        depth_header=title_of(table, depth_at),
        force_header=title_of(table, force_at),
        numbers=(depth_at + 1, force_at + 1),
        units=(factors["depth"][1], factors["force"][1]),
        timed=timed,
        notes=tuple(notes),
    )


def _options(table: Table, units: Sequence[Unit], role: str) -> list[int]:
    """Return the columns that may be a role: by unit, where their name says it or nothing; else by name."""
    numeric = [i for i, is_number in enumerate(table.numeric) if is_number]
    numeric = [i for i in numeric if np.nanmin(table.numbers[:, i]) < np.nanmax(table.numbers[:, i])] or numeric
    named = [i for i in numeric if role_of(table.names[i]) == role and kind_of(units[i]) in (None, KIND[role])]
    measured = [i for i in numeric if kind_of(units[i]) == KIND[role] and role_of(table.names[i]) in (None, role)]
    if role == "time":
        return [i for i in named if i in measured] or named or measured
    return measured if any(i in measured for i in named) else named or measured


def _unnamed(table: Table, units: Sequence[Unit]) -> list[int]:
    """Return the columns that could be anything, else all with numbers."""
    numeric = [i for i, is_number in enumerate(table.numeric) if is_number]
    free = [i for i in numeric if role_of(table.names[i]) is None and kind_of(units[i]) is None]
    return free if len(free) > 1 else numeric


def _named(table: Table, name: str, role: str) -> int:
    """Return the column an answer means: a number counted from 1, or a header."""
    if name.isdigit() and 1 <= int(name) <= len(table.names):
        at = int(name) - 1
    else:
        wanted = name.strip().lower()
        found = [i for i, each in enumerate(table.names) if wanted in (each.lower(), title_of(table, i).lower())]
        if len(found) != 1:
            raise DimpleError(
                "No single column is called “{name}”. Give its number, 1 to {most}.", name=name, most=len(table.names)
            )
        at = found[0]
    count, rows = int(np.isfinite(table.numbers[:, at]).sum()), len(table.numbers)
    if count < MIN_ROWS:
        few = "numbers in {count} of {rows:,} rows only" if count else "no numbers"
        raise DimpleError(
            "Column {number} ({title}) holds {few}, so it cannot be the {role}.",
            number=at + 1, title=title_of(table, at), few=Message(few, count=count, rows=rows),
            role=Message(role)
        )  # fmt: skip
    return at


def _beside(
    table: Table, units: Sequence[Unit], role: str, options: Sequence[int], given: dict[str, int]
) -> int | None:
    """Return the column of the test that the other role was given of, where tests of one header stand side by side."""
    other = "force" if role == "depth" else "depth"
    others = _options(table, units, other)
    paired = len(others) == len(options) > 1 and given.get(other) in others
    same = all(len({table.names[i] for i in columns}) == 1 for columns in (options, others))
    return options[others.index(given[other])] if paired and same else None


def _alike(columns: Floats) -> bool:
    """Return whether columns (n, c) are one but for sign and zero."""
    finite = np.isfinite(columns)
    if (finite != finite[:, :1]).any():
        return False
    first = columns[:, 0] - np.nanmean(columns[:, 0])
    span = float(np.ptp(first[np.isfinite(first)]))
    for other in columns.T[1:]:
        centred = other - np.nanmean(other)
        if min(np.nanmax(np.abs(centred - first)), np.nanmax(np.abs(centred + first))) > _SAME * span:
            return False
    return True


def _check_distinct(table: Table, chosen: dict[str, int | None], questions: list[Question], sole: bool) -> None:
    """Refuse one column for both; where `sole`, the column that is left is the other one."""
    if chosen["depth"] is not None and chosen["depth"] == chosen["force"]:
        raise DimpleError("{title} cannot be both the depth and the force.", title=title_of(table, chosen["depth"]))
    if sum(table.numeric) < 2:
        raise DimpleError("The table has one column of numbers; it needs a depth and a force.")
    for role, other in (("depth", "force"), ("force", "depth")):
        if sole and chosen[role] is None and chosen[other] is not None and sum(table.numeric) == 2:
            chosen[role] = next(i for i, is_number in enumerate(table.numeric) if is_number and i != chosen[other])
            questions[:] = [question for question in questions if question.name != f"{role}_column"]


def _in_time(table: Table, units: Sequence[Unit], notes: list[str]) -> tuple[Table, bool]:
    """Return a table whose clock or count of rows runs forward, and whether it has one."""
    time_at = _time_column(table, units)
    counts = [i for i, name in enumerate(table.names) if table.numeric[i] and _COUNT.fullmatch(name.strip())]
    for at in [*([] if time_at is None else [time_at]), *counts]:
        steps = np.diff(table.numbers[:, at])
        if (steps < 0).all():
            notes.append(Message(
                "The rows stand from the last to the first by {title}; they were turned round.",
                title=title_of(table, at)
            ))  # fmt: skip
            cells = tuple(column[::-1] for column in table.cells)
            return replace(table, numbers=table.numbers[::-1], cells=cells), True
        if (steps > 0).all():
            return table, True
    return table, False


def _time_column(table: Table, units: Sequence[Unit]) -> int | None:
    options = [i for i in _options(table, units, "time") if np.isfinite(table.numbers[:, i]).all()]
    return options[0] if options else None


def _check_clock(table: Table, time_at: int, depth_at: int) -> None:
    """Ask where the column called time does not run like a clock, or the depth runs like one in its stead."""
    time, depth = table.numbers[:, time_at], table.numbers[:, depth_at]
    back = float((np.diff(time) < 0).mean())
    steps = np.diff(depth[np.isfinite(depth)])
    like_a_clock = depth[0] == 0 and len(steps) > 0 and steps.min() > 0 and np.ptp(steps) < 1e-2 * steps.mean()
    if back > _BACKWARD or (time.min() < 0 and like_a_clock):
        numeric = [i for i, is_number in enumerate(table.numeric) if is_number]
        why = Message(
            "“{title}” does not run like a clock: the headers may stand over the wrong columns.",
            title=title_of(table, time_at),
        )
        questions = [_which_column(table, role, numeric) for role in ("depth", "force")]
        raise Undecided(replace(questions[0], text=in_a_row([why, questions[0].text])), questions[1])


def _which_column(table: Table, role: str, options: Sequence[int]) -> Question:
    return Question(
        name=f"{role}_column",
        text=Message("Which column is the {role}?", role=Message(role)),
        candidates=tuple(
            Candidate(value=str(i + 1), label=f"{title_of(table, i)}: {preview(table.numbers[:, i])}") for i in options
        ),
    )


def preview(values: Floats) -> str:
    """Show a column: its first numbers and its range."""
    values = values[np.isfinite(values)]
    first = ", ".join(f"{value:g}" for value in values[:3])
    return Message("{first}, ... from {least:g} to {most:g}", first=first, least=values.min(), most=values.max())
