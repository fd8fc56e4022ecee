"""The plan of an experiment, from a JSON or CSV file: tasks, their order for a participant, and blind labels.

JSON: {"name", "seed", "consent", "tasks": [...]}, a task as a row of the CSV: kind (rating or comparison), condition
(felt or seen), object, repeats; of a rating its steps; of a comparison its method (constant or staircase), levels or
start, step and trials. A level is a factor on the stiffness K1 and K2 of the object; lists in a CSV cell are separated
by spaces, or by | where they are words.
"""

from __future__ import annotations

import csv
import io
import json
import math
import random
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ..errors import DimpleError
from ..messages import Message

CONSENT: Final = (
    "You will press soft objects and say how they feel. A haptic device may push your fingers with up to 10 N; it does "
    "so only while you hold the key, and Esc stops at any time, without a reason. Answers, forces and depths are kept "
    "under a number, not under your name."
)
STEPS: Final = ("Different", "Slightly Alike", "Alike", "The Same")  # ours: the paper names none of its four
CONDITIONS: Final = ("felt", "seen")
LEVELS: Final = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
LEAST, MOST = 0.05, 20.0  # of a level
LONGEST: Final = 10_000  # trials of a participant


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A part of an experiment.

    kind: "rating" or "comparison".
    condition: "felt" (by a device) or "seen" (a press is replayed); never pooled.
    object: name of the material or of the preset.
    repeats: of the object, or of each level.
    steps: of a rating, the least alike first.
    method: of a comparison, "constant" or "staircase".
    levels: factors on the stiffness, of constant stimuli.
    start, step: of a staircase; the step is a share of the level.
    """

    kind: str
    condition: str
    object: str
    repeats: int
    steps: tuple[str, ...] = STEPS
    method: str = "constant"
    levels: tuple[float, ...] = LEVELS
    start: float = 1.5
    step: float = 0.1

    @property
    def trials(self) -> int:
        """Return how many trials it has."""
        many = self.kind == "comparison" and self.method == "constant"
        return self.repeats * (len(self.levels) if many else 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExperimentPlan:
    """An experiment.

    name: of it.
    seed: of all order and chance.
    consent: shown before the first trial.
    tasks: its parts.
    """

    name: str
    seed: int
    consent: str
    tasks: tuple[Task, ...]

    @property
    def checksum(self) -> str:
        """Return what differs between two plans."""
        return f"{zlib.crc32(repr((self.seed, self.tasks)).encode()):08x}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """A place in the order of a participant.

    task: number of the task.
    level: factor on the stiffness, None where a staircase chooses it.
    test_first: of a comparison, the test comes before the reference.
    label: blind name of the object.
    """

    task: int
    level: float | None
    test_first: bool
    label: str


def order(plan: ExperimentPlan, participant: str) -> list[Slot]:
    """Return the trials of a participant: tasks in a seeded order, the trials of each shuffled."""
    dice = random.Random(f"{plan.seed} {participant}")
    names = sorted({task.object for task in plan.tasks})
    labels = [chr(ord("A") + i) if i < 26 else f"A{i}" for i in range(len(names))]
    dice.shuffle(labels)
    label = dict(zip(names, labels, strict=True))
    tasks = list(range(len(plan.tasks)))
    dice.shuffle(tasks)
    slots = []
    for number in tasks:
        task = plan.tasks[number]
        levels: list[float | None] = [1.0] * task.repeats
        if task.kind == "comparison":
            levels = [None] * task.repeats if task.method == "staircase" else [*task.levels] * task.repeats
            dice.shuffle(levels)
        firsts = [i % 2 == 0 for i in range(len(levels))]
        dice.shuffle(firsts)
        slots += [
            Slot(task=number, level=level, test_first=first, label=label[task.object])
            for level, first in zip(levels, firsts, strict=True)
        ]
    return slots


def read_plan(path: Path) -> ExperimentPlan:
    """Return the plan in a file.

    Raises:
        DimpleError: it cannot be read, or what is wrong where.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise DimpleError("The experiment {name} cannot be read: {error}.", name=path.name, error=error) from None
    try:
        if path.suffix.lower() == ".csv":
            rows = list(csv.DictReader(io.StringIO(text)))
            return make_plan({"name": path.stem, "tasks": [_cells(row) for row in rows]})
        return make_plan({"name": path.stem, **json.loads(text)})
    except (ValueError, TypeError, AttributeError) as error:
        raise DimpleError("{name} is not an experiment: {error}.", name=path.name, error=error) from None


def make_plan(file: Mapping[str, Any]) -> ExperimentPlan:
    """Return the plan of what a file says.

    Raises:
        DimpleError: something is wrong in it, with the number of the task.
    """
    tasks = [_task(number, task) for number, task in enumerate(file.get("tasks") or [], start=1)]
    if not tasks:
        raise DimpleError("The experiment has no tasks.")
    if sum(task.trials for task in tasks) > LONGEST:
        raise DimpleError("The experiment has more than {most} trials.", most=LONGEST)
    name = str(file["name"])
    seed = int(file.get("seed", zlib.crc32(name.encode())))
    return ExperimentPlan(name=name, seed=seed, consent=str(file.get("consent") or CONSENT), tasks=tuple(tasks))


def _cells(row: Mapping[str, str | None]) -> dict[str, Any]:
    """Return a row of a CSV as a task; empty cells say nothing."""
    given: dict[str, Any] = {name.strip(): cell.strip() for name, cell in row.items() if name and cell and cell.strip()}
    if "levels" in given:
        given["levels"] = given["levels"].split()
    if "steps" in given:
        given["steps"] = [word.strip() for word in given["steps"].split("|")]
    return given


def _task(number: int, given: Mapping[str, Any]) -> Task:
    known = set(Task.__dataclass_fields__)
    try:
        if unknown := sorted(set(given) - known):
            raise ValueError(Message("it has no {unknown}", unknown=tuple(unknown)))
        task = Task(
            kind=str(given.get("kind", "")), condition=str(given.get("condition", "felt")),
            object=str(given.get("object", "")), repeats=_whole("repeats", given.get("repeats", 1)),
            steps=tuple(str(step) for step in given.get("steps", STEPS)), method=str(given.get("method", "constant")),
            levels=tuple(_number("a level", level) for level in given.get("levels", LEVELS)),
            start=_number("start", given.get("start", 1.5)), step=_number("step", given.get("step", 0.1)),
        )  # fmt: skip
        _check(task)
    except (ValueError, TypeError) as error:
        raise DimpleError("Task {number} of the experiment: {error}.", number=number, error=error) from None
    return task


def _check(task: Task) -> None:
    for what, holds in (
        ("kind must be rating or comparison", task.kind in ("rating", "comparison")),
        (Message("condition must be {conditions}", conditions=" or ".join(CONDITIONS)), task.condition in CONDITIONS),
        ("object must name a material", bool(task.object)),
        ("repeats must be 1 or more", task.repeats >= 1),
        ("steps must be 2 to 9 different words", 2 <= len(set(task.steps)) == len(task.steps) <= 9),
        ("method must be constant or staircase", task.method in ("constant", "staircase")),
        ("levels must be two or more", task.kind == "rating" or len(set(task.levels)) >= 2),
        (Message("a level must be from {least} to {most}", least=LEAST, most=MOST),
         all(LEAST <= x <= MOST for x in (*task.levels, task.start))),
        ("step must be above 0 and below 1", 0 < task.step < 1),
    ):  # fmt: skip
        if not holds:
            raise ValueError(Message(what))


def _number(name: str, value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(Message("{name} must be a number", name=name))
    return number


def _whole(name: str, value: Any) -> int:
    number = _number(name, value)
    if number != round(number):
        raise ValueError(Message("{name} must be a whole number", name=name))
    return round(number)
