"""The plan of an experiment: a JSON file that states every trial of every participant, in order.

Nothing is random here. `dev.py core experiment` writes such files; docs/experiment.md explains each entry.
"""

from __future__ import annotations

import json
import math
from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from ..errors import DimpleError


@dataclass(frozen=True, slots=True, kw_only=True)
class Stimulus:
    """The stimulus of one interval: a real object, or the virtual one with the constants of a labelled object."""

    real: str = ""  # label of the real object, which the experimenter puts in place; "" for a virtual one
    object: str = ""  # label of the object whose constants the virtual one has; "" for a real one
    level: float = 1.0  # factor on its K1 and K2


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A trial of one interval, or of two in order."""

    show: tuple[Stimulus, ...]
    part: str = "main"  # or "practice", or "catch" with the numbers of the correct answers
    rest_s: float = 0.0  # [s] break before the trial
    number: int = 0  # counted from 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """An experiment: the texts for participants, and the trials of each."""

    consent: str
    instruction: str
    question: str
    answers: list[str]
    exposure_s: float  # [s] least time of contact with each object
    trial_s: float  # [s] approximate duration of a trial
    press_n: float  # [N] force up to which objects are pressed and must be rendered faithfully
    objects: dict[str, str]  # label: preset or material
    participants: dict[str, tuple[Trial, ...]]  # code of the participant: trials
    made: dict[str, Any] = field(default_factory=dict)  # notes of the program that made the plan, such as a seed

    def stimuli(self) -> set[tuple[str, float]]:
        """Return label and level of every virtual stimulus."""
        shown = [each for trials in self.participants.values() for trial in trials for each in trial.show]
        return {(each.object, each.level) for each in shown if each.object}


def read_plan(path: Path) -> Plan:
    """Return the plan in a file.

    Raises:
        DimpleError: it cannot be read, or an entry is wrong or missing; the message names it.
    """
    try:
        plan = _made(Plan, json.loads(path.read_text(encoding="utf-8-sig")))
    except (OSError, ValueError) as error:
        raise DimpleError("The experiment {name} cannot be read: {error}.", name=path.name, error=error) from None
    _require(len(plan.answers) > 1 and all(_is("str", each) for each in plan.answers), "answers")
    _require(all(_is("str", each) for each in plan.objects.values()), "objects")
    people = {}
    for code, trials in plan.participants.items():
        _require(_is("list", trials) and code.isalnum(), "participants", code)
        people[code] = tuple(_trial(plan, each, number, code) for number, each in enumerate(trials, start=1))
    return replace(plan, participants=people)


def _trial(plan: Plan, given: Any, number: int, code: str) -> Trial:
    where = "participants", code, str(number)
    trial = _made(Trial, given, *where)
    show = tuple(_made(Stimulus, each, *where) for each in trial.show)
    _require(len(show) in (1, 2), *where, "show")
    for each in show:
        _require(bool(each.real) != bool(each.object) and (each.real or each.object) in plan.objects, *where, "object")
    return replace(trial, show=show, number=number)


def _made(kind: type, given: Any, *where: str) -> Any:
    """Return a part of a plan (Plan, Trial or Stimulus) after a check that each entry has its declared type."""
    _require(_is("dict", given), *where)
    known = {each.name: each for each in fields(kind)}
    needed = [name for name, each in known.items() if each.default is each.default_factory is MISSING]
    for name in [*given, *needed]:
        _require(name in given and name in known and _is(str(known[name].type), given[name]), *where, name)
    return kind(**given)


def _is(kind: str, value: Any) -> bool:
    """Return whether a value from a file has a type, given as text; a string must be one line, a number finite."""
    if kind == "str":
        return isinstance(value, str) and value.isprintable()
    if kind in ("int", "float"):
        return isinstance(value, int if kind == "int" else int | float) and 0 <= abs(value) < math.inf
    return isinstance(value, dict if kind.startswith("dict") else list)


def _require(holds: bool, *where: str) -> None:
    if not holds:
        raise DimpleError("The experiment has a wrong or missing entry: {where}. See docs/experiment.md.", where=where)
