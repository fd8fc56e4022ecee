"""Which column is the depth, which the force, and in what units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from .question import Answers, Candidate, Question, Undecided
from .table import Table
from .vocabulary import role_of, unit_of

_KIND = {"force": "force", "depth": "length", "time": "time"}
_SAME = 0.01  # of the range: columns nearer than this say the same
_BACKWARD = 0.02  # of the rows: a clock may start again with each cycle, no more
_CHOICES = {"force": ("N", "gf", "kgf", "mN", "kN", "lbf"), "depth": ("mm", "m", "um", "in")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """The columns of depth and force.

    depth: (n,) [m], NaN where a cell is no number.
    force: (n,) [N], NaN where a cell is no number.
    depth_header: of the column.
    force_header: of the column.
    numbers: of both columns, counted from 1.
    notes: messages about how they were read.
    """

    depth: Floats
    force: Floats
    depth_header: str
    force_header: str
    numbers: tuple[int, int]
    notes: tuple[str, ...]


def find_columns(table: Table, answers: Answers) -> Columns:
    """Choose and convert the columns.

    Raises:
        Undecided: a column or a unit could be several, with all that is open at once.
        DimpleError: there is nothing to choose from, or an answer names nothing.
    """
    units = _units(table)
    notes: list[str] = []
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
        if len(options) > 1 and _alike(table.numbers[:, options]):
            notes.append(f"{_title(table, options[0])} was taken; {_title(table, options[1])} says the same.")
            options = options[:1]
        chosen[role] = options[0] if len(options) == 1 and role_of(table.names[options[0]]) == role else None
        if chosen[role] is None and len(options) == 1 and _kind(units[options[0]]) == _KIND[role]:
            chosen[role] = options[0]
        if chosen[role] is None:
            questions.append(_which_column(table, role, options or left(_unnamed(table, units))))
    _check_distinct(table, chosen, questions, bool(given) or not any(table.names))
    factors: dict[str, Floats | float] = {}
    for role in ("depth", "force"):
        factor = _factor(table, units, chosen[role], role, getattr(answers, f"{role}_unit"), notes)
        if factor is None:
            questions.append(_which_unit(table, role, chosen[role]))
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
        depth=table.numbers[:, depth_at] * factors["depth"],
        force=table.numbers[:, force_at] * factors["force"],
        depth_header=_title(table, depth_at),
        force_header=_title(table, force_at),
        numbers=(depth_at + 1, force_at + 1),
        notes=tuple(notes),
    )


def _units(table: Table) -> list[str | tuple[str, ...]]:
    """Return the unit of each column: written in its header, in a column beside it (one a row), or listed above."""
    units: list[str | tuple[str, ...]] = list(table.units)
    for i in range(1, len(units)):
        if not table.numeric[i] and table.numeric[i - 1] and not units[i - 1]:
            cells = table.cells[i]
            if all(unit_of(cell) for cell in set(cells)):
                units[i - 1] = cells[0] if len(set(cells)) == 1 else cells
    numeric = [i for i, is_number in enumerate(table.numeric) if is_number]
    for key, value in table.values.items():
        if not re.search(r"unit|einheit|単位", key):
            continue
        listed = [word.strip() for word in re.split(r"[,;\s]+", value) if word.strip()]
        known = [word for word in listed if unit_of(word)]
        if len(known) == len(listed) == len(numeric) and not any(units[i] for i in numeric):
            for i, unit in zip(numeric, known, strict=True):
                units[i] = unit
        elif len(known) == 1 and (role := role_of(re.sub(r"units?|einheit|単位", "", key))) in ("force", "depth"):
            for i in numeric:
                if role_of(table.names[i]) == role and not units[i]:
                    units[i] = known[0]
    return units


def _kind(unit: str | tuple[str, ...]) -> str | None:
    found = unit_of(unit if isinstance(unit, str) else unit[0]) if unit else None
    return found[0] if found else None


def _options(table: Table, units: Sequence[str | tuple[str, ...]], role: str) -> list[int]:
    """Return the columns that may be a role: by unit, where their name says it or nothing; else by name."""
    numeric = [i for i, is_number in enumerate(table.numeric) if is_number]
    numeric = [i for i in numeric if np.nanmin(table.numbers[:, i]) < np.nanmax(table.numbers[:, i])] or numeric
    named = [i for i in numeric if role_of(table.names[i]) == role and _kind(units[i]) in (None, _KIND[role])]
    measured = [i for i in numeric if _kind(units[i]) == _KIND[role] and role_of(table.names[i]) in (None, role)]
    if role == "time":
        return [i for i in named if i in measured] or named or measured
    return measured if any(i in measured for i in named) else named or measured


def _unnamed(table: Table, units: Sequence[str | tuple[str, ...]]) -> list[int]:
    """Return the columns that could be anything, else all with numbers."""
    numeric = [i for i, is_number in enumerate(table.numeric) if is_number]
    free = [i for i in numeric if role_of(table.names[i]) is None and _kind(units[i]) is None]
    return free if len(free) > 1 else numeric


def _named(table: Table, name: str, role: str) -> int:
    """Return the column an answer means: a number counted from 1, or a header."""
    if name.isdigit() and 1 <= int(name) <= len(table.names):
        at = int(name) - 1
    else:
        wanted = name.strip().lower()
        found = [i for i, each in enumerate(table.names) if wanted in (each.lower(), _title(table, i).lower())]
        if len(found) != 1:
            raise DimpleError(f"No single column is called “{name}”. Give its number, 1 to {len(table.names)}.")
        at = found[0]
    if not table.numeric[at]:
        raise DimpleError(f"Column {at + 1} ({_title(table, at)}) holds no numbers, so it cannot be the {role}.")
    return at


def _alike(columns: Floats) -> bool:
    """Return whether columns (n, c) are one but for sign and zero."""
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
        raise DimpleError(f"{_title(table, chosen['depth'])} cannot be both the depth and the force.")
    if sum(table.numeric) < 2:
        raise DimpleError("The table has one column of numbers; it needs a depth and a force.")
    for role, other in (("depth", "force"), ("force", "depth")):
        if sole and chosen[role] is None and chosen[other] is not None and sum(table.numeric) == 2:
            chosen[role] = next(i for i, is_number in enumerate(table.numeric) if is_number and i != chosen[other])
            questions[:] = [question for question in questions if question.name != f"{role}_column"]


def _factor(
    table: Table, units: Sequence[str | tuple[str, ...]], at: int | None, role: str, given: str | None, notes: list[str]
) -> Floats | float | None:
    """Return the factor to SI of a column, one a row where the unit changes; None where it is not known."""
    kind = _KIND[role]
    if given is not None:
        found = unit_of(given)
        if found is None or found[0] != kind:
            raise DimpleError(f"“{given}” is not a unit of {kind}. Use one of {', '.join(_CHOICES[role])}.")
        return found[1]
    counts = [value for key, value in table.values.items() if re.search(r"counts\s*(per|/)\s*(unit )?force", key)]
    unit = units[at] if at is not None else ""
    if role == "force" and counts and at is not None:
        units_above = [value for key, value in table.values.items() if re.search(r"force units?", key)]
        found = unit_of(units_above[0]) if units_above else None
        try:
            divisor = float(counts[0].replace(",", ""))
        except ValueError:
            return None
        if found is None or found[0] != "force" or not divisor > 0:
            return None
        notes.append(f"Counts were divided by {divisor:g}, as the file says, to get {units_above[0]}.")
        return found[1] / divisor
    if at is None or not unit or _kind(unit) != kind:
        return None if at is not None else 1.0  # the column comes first
    if isinstance(unit, tuple):
        parts = [unit_of(cell) for cell in unit]
        if any(part is None or part[0] != kind for part in parts):
            return None
        notes.append(f"The unit of {_title(table, at)} changes within the file; each row was converted by its own.")
        return np.array([part[1] for part in parts if part is not None])
    if unit.lower().strip("()[]. ") in ("g", "gr", "gram", "grams", "kg", "lb", "lbs", "oz"):
        notes.append(f"{_title(table, at)}: {unit} was taken as a force, the weight of that mass.")
    found = unit_of(unit)
    return found[1] if found else None


def _time_column(table: Table, units: Sequence[str | tuple[str, ...]]) -> int | None:
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
        why = f"“{_title(table, time_at)}” does not run like a clock: the headers may stand over the wrong columns. "
        questions = [_which_column(table, role, numeric) for role in ("depth", "force")]
        raise Undecided(replace(questions[0], text=why + questions[0].text), questions[1])


def _title(table: Table, at: int) -> str:
    unit = table.units[at]
    return (table.names[at] + (f" ({unit})" if unit else "")) or f"column {at + 1}"


def _which_column(table: Table, role: str, options: Sequence[int]) -> Question:
    return Question(
        name=f"{role}_column",
        text=f"Which column is the {role}?",
        candidates=tuple(
            Candidate(value=str(i + 1), label=f"{_title(table, i)}: {preview(table.numbers[:, i])}") for i in options
        ),
    )


def _which_unit(table: Table, role: str, at: int | None) -> Question:
    assert at is not None
    values = table.numbers[:, at][np.isfinite(table.numbers[:, at])]
    reach = float(np.abs(values).max(initial=0))
    return Question(
        name=f"{role}_unit",
        text=f"In what unit is {_title(table, at)}? It reaches {reach:g}.",
        candidates=tuple(
            Candidate(value=unit, label=_reach(reach, unit, role)) for unit in _CHOICES[role] if unit_of(unit)
        ),
    )


def _reach(reach: float, unit: str, role: str) -> str:
    found = unit_of(unit)
    value = reach * (found[1] if found else 1.0)
    return f"then it reaches {value:.4g} N" if role == "force" else f"then it reaches {1e3 * value:.4g} mm"


def preview(values: Floats) -> str:
    """Show a column: its first numbers and its range."""
    values = values[np.isfinite(values)]
    first = ", ".join(f"{value:g}" for value in values[:3])
    return f"{first}, ... from {values.min():g} to {values.max():g}"
