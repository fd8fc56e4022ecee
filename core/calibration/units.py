"""In what units the columns of a table are, and what makes them SI."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .dialect import number
from .question import Candidate, Question
from .table import Table
from .vocabulary import role_of, unit_of

Unit = str | tuple[str, ...]  # of a column, or one for each row
KIND = {"force": "force", "depth": "length", "time": "time"}
_CHOICES = {"force": ("N", "gf", "kgf", "mN", "kN", "lbf"), "depth": ("mm", "m", "um", "in")}


def written_units(table: Table) -> list[Unit]:
    """Return the unit of each column: written in its header, in a column beside it (one a row), or listed above."""
    units: list[Unit] = list(table.units)
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


def kind_of(unit: Unit) -> str | None:
    """Return the kind of a unit, see `unit_of`; of units one a row that of the first."""
    found = unit_of(unit if isinstance(unit, str) else unit[0]) if unit else None
    return found[0] if found else None


def factor_to_si(
    table: Table, units: Sequence[Unit], at: int | None, role: str, given: str | None, notes: list[str]
) -> tuple[Floats | float, str] | None:
    """Return the factor to SI of a column, one a row where the unit changes, and the unit; None where not known."""
    kind = KIND[role]
    if given is not None:
        found = unit_of(given)
        if found is None or found[0] != kind:
            raise DimpleError(
                "“{given}” is not a unit of {kind}. Use one of {choices}.",
                given=given,
                kind=Message(kind),
                choices=tuple(_CHOICES[role]),
            )
        return found[1], given
    counts = [value for key, value in table.values.items() if re.search(r"counts\s*(per|/)\s*(unit )?force", key)]
    unit = units[at] if at is not None else ""
    if role == "force" and counts and at is not None:
        units_above = [value for key, value in table.values.items() if re.search(r"force units?", key)]
        found = unit_of(units_above[0]) if units_above else None
        divisor = number(counts[0], ".")
        if found is None or found[0] != "force" or divisor is None or not divisor > 0:
            return None
        notes.append(
            Message(
                "Counts were divided by {divisor:g}, as the file says, to get {units_above}.",
                divisor=divisor,
                units_above=units_above[0],
            )
        )
        return found[1] / divisor, Message(
            "counts of {units_above}/{divisor:g}", units_above=units_above[0], divisor=divisor
        )
    if at is None or not unit or kind_of(unit) != kind:
        return None if at is not None else (1.0, "")  # the column comes first
    if isinstance(unit, tuple):
        parts = [unit_of(cell) for cell in unit]
        if any(part is None or part[0] != kind for part in parts):
            return None
        notes.append(
            Message(
                "The unit of {title} changes within the file; each row was converted by its own.",
                title=title_of(table, at),
            )
        )
        return np.array([part[1] for part in parts if part is not None]), " or ".join(dict.fromkeys(unit))
    if unit.lower().strip("()[]. ") in ("g", "gr", "gram", "grams", "kg", "lb", "lbs", "oz"):
        notes.append(
            Message(
                "{title}: {unit} was taken as a force, the weight of that mass.", title=title_of(table, at), unit=unit
            )
        )
    found = unit_of(unit)
    return (found[1], unit.strip("()[]{}<> ")) if found else None


def title_of(table: Table, at: int) -> str:
    """Return what a column is called in a question: its name and unit, or its number."""
    unit = table.units[at]
    return (table.names[at] + (f" ({unit})" if unit else "")) or Message("column {number}", number=at + 1)


def which_unit(table: Table, role: str, at: int | None) -> Question:
    """Return the question in what unit a column is."""
    assert at is not None
    values = table.numbers[:, at][np.isfinite(table.numbers[:, at])]
    reach = float(np.abs(values).max(initial=0))
    return Question(
        name=f"{role}_unit",
        text=Message("In what unit is {title}? It reaches {reach:g}.", title=title_of(table, at), reach=reach),
        candidates=tuple(
            Candidate(value=unit, label=_reach(reach, unit, role)) for unit in _CHOICES[role] if unit_of(unit)
        ),
    )


def _reach(reach: float, unit: str, role: str) -> str:
    found = unit_of(unit)
    value = reach * (found[1] if found else 1.0)
    return (
        Message("then it reaches {value:.4g} N", value=value)
        if role == "force"
        else Message("then it reaches {value:.4g} mm", value=1e3 * value)
    )
