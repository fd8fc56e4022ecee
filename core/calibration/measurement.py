"""From an instrument's file to its measurement: depth and force in SI, in the file's own zero and sign."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .columns import check_clock, choose, in_time
from .known_words_and_units import KIND, unit_of
from .question import Answers, Candidate, Question, Undecided
from .reader import find_dialect, load_lines, number
from .table import MIN_ROWS, Table, find_table

_CHOICES = {"force": ("N", "gf", "kgf", "mN", "kN", "lbf"), "depth": ("mm", "m", "um", "in")}
_MASSES = ("g", "gr", "gram", "grams", "kg", "lb", "lbs", "oz")


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


def read_measurement(path: str | Path, answers: Answers | None = None) -> Measurement:
    """Read a force-depth file; rows without a depth or a force are left out.

    Args:
        answers: of the user to earlier questions.

    Raises:
        Undecided: the file can be read in several ways; its questions say which, all that are open at once.
        DimpleError: the file is not a force-depth table, or beyond the limits.
    """
    answers = answers or Answers()
    lines, notes = load_lines(path)
    table = find_table(lines, find_dialect(lines, answers.decimal), answers)
    notes += table.notes
    warnings = [*table.warnings]
    table, timed = in_time(table, notes)
    chosen, questions = choose(table, answers, notes)
    factors: dict[str, tuple[float, str]] = {}
    for role, at in chosen.items():
        factor = _factor_to_si(table, at, role, getattr(answers, f"{role}_unit"), notes)
        if factor is None:
            questions.append(_which_unit(table, role, at))
        else:
            factors[role] = factor
    if questions:
        raise Undecided(*questions)
    both = (chosen["depth"], chosen["force"])
    if answers.depth_column is None and answers.force_column is None:
        check_clock(table, both[0])
    rows = _whole_rows(table.numbers[:, both], notes, warnings)
    return Measurement(
        source=Path(path).name,
        depth=rows[:, 0] * factors["depth"][0], force=rows[:, 1] * factors["force"][0],
        depth_header=table.title(both[0]), force_header=table.title(both[1]),
        columns=(both[0] + 1, both[1] + 1), units=(factors["depth"][1], factors["force"][1]),
        timed=timed, notes=tuple(notes), warnings=tuple(warnings),
    )  # fmt: skip


def _factor_to_si(table: Table, at: int, role: str, given: str | None, notes: list[str]) -> tuple[float, str] | None:
    """Return the factor to SI of a column and the unit; None where it is not known."""
    unit = (given or table.units[at]).strip("()[]{}<> ")
    found = unit_of(unit)
    if found is not None and found[0] != KIND[role]:
        found = None
    if given is not None:
        if found is None:
            raise DimpleError(
                "“{given}” is not a unit of {kind}. Use one of {choices}.",
                given=given,
                kind=Message(KIND[role]),
                choices=tuple(_CHOICES[role]),
            )
        return found[1], unit
    for key, value in table.values.items():
        if role == "force" and re.search(r"counts\s*(per|/)\s*(unit )?force", key):
            return _of_counts(table, value, notes)
    if found is not None and unit.lower().strip(". ") in _MASSES:
        notes.append(
            Message("{title}: {unit} was taken as a force, the weight of that mass.", title=table.title(at), unit=unit)
        )
    return (found[1], unit) if found else None


def _of_counts(table: Table, counts: str, notes: list[str]) -> tuple[float, str] | None:
    """Return the factor to SI of a force in counts, of which the file says how many make a unit."""
    unit = next((value for key, value in table.values.items() if re.search(r"force units?", key)), "")
    found, divisor = unit_of(unit), number(counts, ".")
    if found is None or found[0] != "force" or divisor is None or not divisor > 0:
        return None
    notes.append(
        Message(
            "Counts were divided by {divisor:g}, as the file says, to get {units_above}.",
            divisor=divisor,
            units_above=unit,
        )
    )
    return found[1] / divisor, Message("counts of {units_above}/{divisor:g}", units_above=unit, divisor=divisor)


def _which_unit(table: Table, role: str, at: int) -> Question:
    """Return the question in what unit a column is."""
    reach = float(np.nanmax(np.abs(table.numbers[:, at])))
    then = "then it reaches {value:.4g} N" if role == "force" else "then it reaches {value:.4g} mm"
    candidates = []
    for unit in _CHOICES[role]:
        _, factor = unit_of(unit) or ("", 1.0)
        value = reach * factor * (1 if role == "force" else 1e3)
        candidates.append(Candidate(unit, Message(then, value=value)))
    return Question(
        name=f"{role}_unit",
        text=Message("In what unit is {title}? It reaches {reach:g}.", title=table.title(at), reach=reach),
        candidates=tuple(candidates),
    )


def _whole_rows(rows: Floats, notes: list[str], warnings: list[str]) -> Floats:
    """Return the rows (n, 2) that have a depth and a force."""
    whole = np.asarray(np.isfinite(rows).all(axis=1))
    missing, n = int((~whole).sum()), len(whole)
    if n - missing < MIN_ROWS:
        raise DimpleError(
            "Only {n} rows have both a depth and a force; a fit needs at least {least}.", n=n - missing, least=MIN_ROWS
        )
    if missing:
        serious = missing > 0.05 * n and not whole[: n - missing].all()  # beside a longer test a column just ends
        (warnings if serious else notes).append(
            Message("{missing} of {n} rows have no depth or no force and were left out.", missing=missing, n=n)
        )
    return rows[whole]
