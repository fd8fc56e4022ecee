"""Which columns of a table are the depth and the force, in what units, and their numbers in SI."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message, in_a_row
from .question import Answers, Candidate, Question, Undecided
from .strokes import SLIGHT
from .table import MIN_ROWS, Table
from .units import KIND, Unit, factor_to_si, kind_of, title_of, which_unit, written_units
from .vocabulary import role_of

_COUNT = re.compile(r"(no|nr|number|index|sample|row|point|#|番号|no\.|nr\.)", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """Depth and force as the instrument wrote them, in its own zero and sign.

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


def measurement_of(table: Table, answers: Answers) -> Measurement:
    """Choose and convert the columns; rows without a depth or a force are left out.

    Raises:
        Undecided: a column or a unit could be several, with all that is open at once.
        DimpleError: there is nothing to choose from, or an answer names nothing.
    """
    units = written_units(table)
    notes: list[str] = [*table.notes]
    table, timed = _in_time(table, units, notes)
    questions: list[Question] = []
    chosen = _choose(table, units, answers, notes, questions)
    factors: dict[str, tuple[Floats | float, str]] = {}
    for role, at in chosen.items():
        factor = factor_to_si(table, units, at, role, getattr(answers, f"{role}_unit"), notes)
        if factor is None:
            questions.append(which_unit(table, role, at))
        else:
            factors[role] = factor
    if questions:
        raise Undecided(*questions)
    depth_at, force_at = chosen["depth"], chosen["force"]
    assert depth_at is not None and force_at is not None
    time_at = _time_column(table, units)
    if time_at is not None and answers.depth_column is None and answers.force_column is None:
        _check_clock(table, time_at, depth_at)
    return _whole_rows(Measurement(
        source="",
        depth=table.numbers[:, depth_at] * factors["depth"][0],
        force=table.numbers[:, force_at] * factors["force"][0],
        depth_header=title_of(table, depth_at),
        force_header=title_of(table, force_at),
        columns=(depth_at + 1, force_at + 1),
        units=(factors["depth"][1], factors["force"][1]),
        timed=timed, notes=tuple(notes), warnings=table.warnings,
    ))  # fmt: skip


def _choose(
    table: Table, units: Sequence[Unit], answers: Answers, notes: list[str], questions: list[Question]
) -> dict[str, int | None]:
    """Return the columns of depth and force, None where a question is added."""
    if sum(table.numeric) < 2:
        raise DimpleError("The table has one column of numbers; it needs a depth and a force.")
    named = {"depth": answers.depth_column, "force": answers.force_column}
    given = {role: _named(table, name, role) for role, name in named.items() if name is not None}
    chosen: dict[str, int | None] = dict(given)
    for role in (role for role in named if role not in given):
        options = [i for i in _options(table, units, role) if i not in given.values()]
        if len(options) > 1 and _alike(table.numbers[:, options]):
            notes.append(
                Message(
                    "{title} was taken; {other} says the same.",
                    title=title_of(table, options[0]),
                    other=title_of(table, options[1]),
                )
            )
            options = options[:1]
        sure = len(options) == 1 and (
            role_of(table.names[options[0]]) == role or kind_of(units[options[0]]) == KIND[role]
        )
        chosen[role] = options[0] if sure else None
    for role, other in (("depth", "force"), ("force", "depth")):  # of two columns the one that is left is the other
        if (given or not any(table.names)) and chosen[role] is None and chosen[other] is not None:
            left = [i for i in _numeric(table) if i != chosen[other]]
            chosen[role] = left[0] if len(left) == 1 else None
    if chosen["depth"] is not None and chosen["depth"] == chosen["force"]:
        raise DimpleError("{title} cannot be both the depth and the force.", title=title_of(table, chosen["depth"]))
    for role, other in (("depth", "force"), ("force", "depth")):
        if chosen[role] is None:
            options = [i for i in _options(table, units, role) if i not in given.values()]
            options = options or [i for i in _unnamed(table, units) if i not in given.values()]
            questions.append(_which_column(table, role, options, chosen[other]))
    return {role: chosen[role] for role in ("depth", "force")}


def _numeric(table: Table) -> list[int]:
    return [i for i, is_number in enumerate(table.numeric) if is_number]


def _options(table: Table, units: Sequence[Unit], role: str) -> list[int]:
    """Return the columns that may be a role: by unit, where their name says it or nothing; else by name."""
    numeric = _numeric(table)
    numeric = [i for i in numeric if np.nanmin(table.numbers[:, i]) < np.nanmax(table.numbers[:, i])] or numeric
    named = [i for i in numeric if role_of(table.names[i]) == role and kind_of(units[i]) in (None, KIND[role])]
    measured = [i for i in numeric if kind_of(units[i]) == KIND[role] and role_of(table.names[i]) in (None, role)]
    if role == "time":
        return [i for i in named if i in measured] or named or measured
    return measured if any(i in measured for i in named) else named or measured


def _unnamed(table: Table, units: Sequence[Unit]) -> list[int]:
    """Return the columns that could be anything, else all with numbers."""
    free = [i for i in _numeric(table) if role_of(table.names[i]) is None and kind_of(units[i]) is None]
    return free if len(free) > 1 else _numeric(table)


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
            number=at + 1,
            title=title_of(table, at),
            few=Message(few, count=count, rows=rows),
            role=Message(role),
        )
    return at


def _alike(columns: Floats) -> bool:
    """Return whether columns (n, c) are one but for sign and zero."""
    finite = np.isfinite(columns)
    if (finite != finite[:, :1]).any():
        return False
    centred = columns - np.nanmean(columns, axis=0)
    first, others = centred[:, :1], centred[:, 1:]
    apart = np.minimum(np.nanmax(np.abs(others - first), axis=0), np.nanmax(np.abs(others + first), axis=0))
    return bool((apart <= SLIGHT * (np.nanmax(first) - np.nanmin(first))).all())


def _in_time(table: Table, units: Sequence[Unit], notes: list[str]) -> tuple[Table, bool]:
    """Return a table whose clock or count of rows runs forward, and whether it has one."""
    time_at = _time_column(table, units)
    counts = [i for i, name in enumerate(table.names) if table.numeric[i] and _COUNT.fullmatch(name.strip())]
    for at in [*([] if time_at is None else [time_at]), *counts]:
        steps = np.diff(table.numbers[:, at])
        if (steps < 0).all():
            notes.append(
                Message(
                    "The rows stand from the last to the first by {title}; they were turned round.",
                    title=title_of(table, at),
                )
            )
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
    like_a_clock = depth[0] == 0 and len(steps) > 0 and steps.min() > 0 and np.ptp(steps) < SLIGHT * steps.mean()
    if back > SLIGHT or (time.min() < 0 and like_a_clock):
        why = Message(
            "“{title}” does not run like a clock: the headers may stand over the wrong columns.",
            title=title_of(table, time_at),
        )
        questions = [_which_column(table, role, _numeric(table)) for role in ("depth", "force")]
        raise Undecided(replace(questions[0], text=in_a_row([why, questions[0].text])), questions[1])


def _which_column(table: Table, role: str, options: Sequence[int], beside: int | None = None) -> Question:
    """Ask for a column; of tests side by side the one next to the other column is the likeliest."""
    near = "" if beside is None else str(min(options, key=lambda i: abs(i - beside - 0.1)) + 1)
    return Question(
        name=f"{role}_column",
        text=Message("Which column is the {role}?", role=role),
        candidates=tuple(
            Candidate(
                value=str(i + 1),
                label=Message("{label}: {error}", label=title_of(table, i), error=_preview(table.numbers[:, i])),
            )
            for i in options
        ),
        default=near,
    )


def _preview(values: Floats) -> str:
    """Show a column: its first numbers and its range."""
    values = values[np.isfinite(values)]
    first = ", ".join(f"{value:g}" for value in values[:3])
    return Message("{first}, ... from {least:g} to {most:g}", first=first, least=values.min(), most=values.max())


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
