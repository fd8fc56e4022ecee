"""From an instrument's file to its measurement: depth and force in SI, with the file's own zero and sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..base import DimpleError, Floats
from ..message import Message, in_a_row
from .known_words_and_units import KIND, unit_of
from .question import Answers, Question, Remarks, Undecided
from .reader import find_dialect, load_lines
from .table import MIN_ROWS, SLIGHT, Table, find_table

_CHOICES = {"force": ("N", "gf", "kgf", "mN", "kN", "lbf"), "depth": ("mm", "m", "um", "in")}
_OTHER = {"depth": "force", "force": "depth"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """Depth and force in SI, with the instrument's own zero and sign.

    source: name of the file.
    depth: (n,) [m].
    force: (n,) [N].
    depth_header: header of the column of depth.
    force_header: header of the column of force.
    columns: numbers of both columns, counted from 1.
    units: units of depth and force in the file, as interpreted.
    remarks: notes and warnings from reading the file.
    """

    source: str
    depth: Floats
    force: Floats
    depth_header: str
    force_header: str
    columns: tuple[int, int] = (1, 2)
    units: tuple[str, str] = ("m", "N")
    remarks: Remarks = field(default_factory=Remarks)


def read_measurement(path: str | Path, answers: Answers | None = None) -> Measurement:
    """Read a force-depth file; rows without a depth or a force are left out.

    Args:
        answers: the user's answers to earlier questions.

    Raises:
        Undecided: the file is ambiguous; the exception has a question for each unknown column or unit.
        DimpleError: the file is not a force-depth table, or exceeds the limits.
    """
    answers, remarks = answers or Answers(), Remarks()
    lines = load_lines(path, remarks)
    table = find_table(lines, find_dialect(lines, answers.decimal), answers, remarks)
    chosen, questions = _choose(table, answers, remarks)
    factors: dict[str, tuple[float, str]] = {}
    for role, at in chosen.items():
        factor = _factor_to_si(table, at, role, getattr(answers, f"{role}_unit"))
        if factor is None:
            questions.append(_which_unit(table, role, at))
        else:
            factors[role] = factor
    if questions:
        raise Undecided(*questions)
    both = (chosen["depth"], chosen["force"])
    if answers.depth_column is None and answers.force_column is None:
        _check_clock(table, both[0])
    rows = _whole_rows(table.numbers[:, both], remarks)
    return Measurement(
        source=Path(path).name,
        depth=rows[:, 0] * factors["depth"][0], force=rows[:, 1] * factors["force"][0],
        depth_header=table.title(both[0]), force_header=table.title(both[1]),
        columns=(both[0] + 1, both[1] + 1), units=(factors["depth"][1], factors["force"][1]),
        remarks=remarks,
    )  # fmt: skip


def _factor_to_si(table: Table, at: int, role: str, given: str | None) -> tuple[float, str] | None:
    """Return the factor to SI of a column and its unit, None if the unit is unknown."""
    unit = (given or table.units[at]).strip("()[]{}<> ")
    found = unit_of(unit)
    if found is None or found[0] != KIND[role]:
        if given is None:
            return None
        raise DimpleError(
            "“{given}” is not a unit of {kind}. Use one of {choices}.",
            given=given,
            kind=Message(KIND[role]),
            choices=tuple(_CHOICES[role]),
        )
    return found[1], unit


def _which_unit(table: Table, role: str, at: int) -> Question:
    """Return the question about the unit of a column."""
    reach = float(np.nanmax(np.abs(table.numbers[:, at])))
    then = "then it reaches {value:.4g} N" if role == "force" else "then it reaches {value:.4g} mm"
    candidates = []
    for unit in _CHOICES[role]:
        _, factor = unit_of(unit) or ("", 1.0)
        candidates.append((unit, Message(then, value=reach * factor * (1 if role == "force" else 1e3))))
    text = Message("What is the unit of {title}? Its largest value is {reach:g}.", title=table.title(at), reach=reach)
    return Question(f"{role}_unit", text, *candidates)


def _whole_rows(rows: Floats, remarks: Remarks) -> Floats:
    """Return the rows (n, 2) that have a depth and a force."""
    whole = np.asarray(np.isfinite(rows).all(axis=1))
    missing, n = int((~whole).sum()), len(whole)
    if n - missing < MIN_ROWS:
        raise DimpleError(
            "Only {n} rows have both a depth and a force; a fit needs at least {least}.", n=n - missing, least=MIN_ROWS
        )
    if missing:
        say = remarks.warn if missing > 0.05 * n else remarks.note
        say("{missing} of {n} rows have no depth or no force and were left out.", missing=missing, n=n)
    return rows[whole]


def _choose(table: Table, answers: Answers, remarks: Remarks) -> tuple[dict[str, int], list[Question]]:
    """Return the known columns of depth and force, and a question for each unknown one.

    Raises:
        DimpleError: fewer than two columns have numbers, or an answer names no column.
    """
    if len(table.numeric) < 2:
        raise DimpleError("The table has only one column of numbers; it needs a depth and a force.")
    named = {"depth": answers.depth_column, "force": answers.force_column}
    given = {role: _named(table, name, role) for role, name in named.items() if name is not None}
    chosen, open_options = dict(given), {}
    for role in (role for role in named if role not in given):
        options = open_options[role] = [i for i in _options(table, role) if i not in given.values()]
        if len(options) > 1 and _alike(table.numbers[:, options]):
            title, other = map(table.title, options[:2])
            remarks.note("{title} was used; {other} holds the same.", title=title, other=other)
            options = options[:1]
        if len(options) == 1 and (table.role(options[0]) == role or table.kind(options[0]) == KIND[role]):
            chosen[role] = options[0]
    for role, other in _OTHER.items():  # of two columns, the remaining one is the other role
        if (given or not any(table.names)) and role not in chosen and other in chosen:
            left = [i for i in table.numeric if i != chosen[other]]
            chosen |= {role: left[0]} if len(left) == 1 else {}
    if len(chosen) == 2 and chosen["depth"] == chosen["force"]:
        raise DimpleError("{title} cannot be both the depth and the force.", title=table.title(chosen["depth"]))
    questions = []
    for role in (role for role in named if role not in chosen):
        options = open_options[role] or [i for i in _unnamed(table) if i not in given.values()]
        questions.append(_which_column(table, role, options, chosen.get(_OTHER[role])))
    return chosen, questions


def _options(table: Table, role: str) -> list[int]:
    """Return the columns that may have a role by their unit or their name, if the other does not contradict it."""
    moving = [i for i in table.numeric if np.nanmin(table.numbers[:, i]) < np.nanmax(table.numbers[:, i])]
    numeric = moving or table.numeric
    named = [i for i in numeric if table.role(i) == role and table.kind(i) in (None, KIND[role])]
    measured = [i for i in numeric if table.kind(i) == KIND[role] and table.role(i) in (None, role)]
    if role == "time":
        return [i for i in named if i in measured] or named or measured
    return measured if any(i in measured for i in named) else named or measured


def _unnamed(table: Table) -> Sequence[int]:
    """Return the numeric columns of unknown role and unit; all numeric columns if fewer than two are unknown."""
    free = [i for i in table.numeric if table.role(i) is None and table.kind(i) is None]
    return free if len(free) > 1 else table.numeric


def _named(table: Table, name: str, role: str) -> int:
    """Return the column that an answer names by its number, counted from 1, or its header."""
    if name.isdigit() and 1 <= int(name) <= len(table.names):
        at = int(name) - 1
    else:
        wanted = name.strip().lower()
        found = [i for i, each in enumerate(table.names) if wanted in (each.lower(), table.title(i).lower())]
        if len(found) != 1:
            raise DimpleError(
                "“{name}” does not name one column. Enter its number, 1 to {most}.", name=name, most=len(table.names)
            )
        at = found[0]
    if (count := int(np.isfinite(table.numbers[:, at]).sum())) < MIN_ROWS:
        said = "Column {number} ({title}) has numbers in only {count} rows, so it cannot be the {role}."
        raise DimpleError(said, number=at + 1, title=table.title(at), count=count, role=Message(role))
    return at


def _alike(columns: Floats) -> bool:
    """Return whether columns (n, c) are equal except for sign and zero."""
    spans = np.ptp(columns, axis=0)
    return bool(np.ptp(spans) <= SLIGHT * spans.max() and np.abs(np.corrcoef(columns.T)).min() > 1 - SLIGHT**2)


def _check_clock(table: Table, depth_at: int) -> None:
    """Ask for the columns if the one called time does not run like a clock, or the depth does so in its place."""
    clocks = [i for i in _options(table, "time") if np.isfinite(table.numbers[:, i]).all()]
    for at in clocks[:1]:
        time, driven = table.numbers[:, at], table.numbers[:, depth_at]
        steps = np.diff(driven[np.isfinite(driven)])
        like_a_clock = driven[0] == 0 and len(steps) > 0 and steps.min() > 0 and np.ptp(steps) < SLIGHT * steps.mean()
        backward = float((np.diff(time) < 0).mean())
        if min(backward, 1 - backward) <= SLIGHT and not (time.min() < 0 and like_a_clock):
            continue
        why = "“{title}” does not increase like a time: the headers may be over the wrong columns."
        depth, force = (_which_column(table, role, table.numeric) for role in _OTHER)
        depth.text = in_a_row([Message(why, title=table.title(at)), depth.text])
        raise Undecided(depth, force)


def _which_column(table: Table, role: str, options: Sequence[int], beside: int | None = None) -> Question:
    """Return the question for a column; if tests stand side by side, the one next to `beside` is the likeliest."""
    near = "" if beside is None else str(min(options, key=lambda i: abs(i - beside - 0.1)) + 1)
    candidates = ((str(i + 1), _preview(table, i)) for i in options)
    return Question(f"{role}_column", Message("Which column is the {role}?", role=role), *candidates, default=near)


def _preview(table: Table, at: int) -> str:
    """Show a column: its title, its first numbers and its range."""
    values = table.numbers[np.isfinite(table.numbers[:, at]), at]
    first = ", ".join(f"{value:g}" for value in values[:3])
    span = Message("{first}, ... from {least:g} to {most:g}", first=first, least=values.min(), most=values.max())
    return Message("{label}: {error}", label=table.title(at), error=span)
