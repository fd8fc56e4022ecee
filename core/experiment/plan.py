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
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final, NamedTuple

from ..errors import DimpleError
from ..messages import Message

CONSENT: Final = (
    "You will press soft objects and say how they feel. A haptic device may push your fingers with up to 10 N; it does "
    "so only while you hold the key, and Esc stops at any time, without a reason. Answers, forces and depths are kept "
    "under a number, not under your name."
)
STEPS: Final = ("Different", "Slightly Alike", "Alike", "The Same")  # ours: the paper names none of its four
CONDITIONS: Final = ("felt", "seen")
LEVELS: Final = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)  # two or three just-noticeable differences to either side
LEAST, MOST = 0.05, 20.0  # of a level: beyond, the object is no longer one that a fingertip can press
LONGEST: Final = 10_000  # trials of a participant: more than a day at ten seconds each


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

    kind: str = ""
    condition: str = "felt"
    object: str = ""
    repeats: int = 1
    steps: tuple[str, ...] = STEPS
    method: str = "constant"
    levels: tuple[float, ...] = LEVELS
    start: float = 1.5
    step: float = 0.1

    @property
    def staircase(self) -> bool:
        """Tell whether the levels follow the answers."""
        return self.kind == "comparison" and self.method == "staircase"

    @property
    def shown_levels(self) -> tuple[float, ...]:
        """Return the level of each trial, those of a staircase as if none were answered."""
        if self.kind == "rating":
            return (1.0,) * self.repeats
        return ((self.start,) if self.staircase else self.levels) * self.repeats


@dataclass(frozen=True, slots=True, kw_only=True)
class ExperimentPlan:
    """An experiment: its name, the seed of all order and chance, the text that a participant agrees to, its tasks."""

    name: str
    seed: int
    consent: str
    tasks: tuple[Task, ...]

    @property
    def checksum(self) -> str:
        """Return a text that differs between two plans."""
        return f"{zlib.crc32(repr((self.seed, self.tasks)).encode()):08x}"


class Trial(NamedTuple):
    """A trial.

    number, of: the first is 1; how many there are.
    task, task_number: its task; the first is 0.
    label: blind name of the object, all that a participant may see.
    level: factor on the stiffness of the test.
    test_first: of a comparison, the test comes before the reference.
    """

    number: int
    of: int
    task: Task
    task_number: int
    label: str
    level: float
    test_first: bool

    @property
    def shown(self) -> tuple[float, ...]:
        """Return factors on the stiffness in the order they are shown: one of a rating, two of a comparison."""
        if self.task.kind == "rating":
            return (1.0,)
        return (self.level, 1.0) if self.test_first else (1.0, self.level)


def order(plan: ExperimentPlan, participant: str) -> list[Trial]:
    """Return the trials of a participant: tasks in a seeded order, the trials of each shuffled."""
    dice = random.Random(f"{plan.seed} {participant}")
    names = sorted({task.object for task in plan.tasks})
    labels = [chr(ord("A") + i) if i < 26 else f"A{i}" for i in range(len(names))]
    dice.shuffle(labels)
    tasks, trials, of = list(enumerate(plan.tasks)), list[Trial](), sum(len(task.shown_levels) for task in plan.tasks)
    dice.shuffle(tasks)
    for number, task in tasks:
        levels, label = list(task.shown_levels), labels[names.index(task.object)]
        firsts = [i % 2 == 0 for i in range(len(levels))]
        dice.shuffle(levels)
        dice.shuffle(firsts)
        trials += [Trial(len(trials) + i, of, task, number, label, *each)
                   for i, each in enumerate(zip(levels, firsts, strict=True), start=1)]  # fmt: skip
    return trials


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
            rows = csv.DictReader(io.StringIO(text), skipinitialspace=True)
            tasks = [{k.strip(): cell for k, cell in row.items() if k and cell and cell.strip()} for row in rows]
            return make_plan({"name": path.stem, "tasks": tasks})
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
    if sum(len(task.shown_levels) for task in tasks) > LONGEST:
        raise DimpleError("The experiment has more than {most} trials.", most=LONGEST)
    name = str(file["name"])
    seed = int(file.get("seed", zlib.crc32(name.encode())))
    return ExperimentPlan(name=name, seed=seed, consent=str(file.get("consent") or CONSENT), tasks=tuple(tasks))


def _task(number: int, given: Mapping[str, Any]) -> Task:
    kinds = {each.name: str(each.type) for each in fields(Task)}
    try:
        if unknown := sorted(set(given) - set(kinds)):
            raise ValueError(Message("it has no {unknown}", unknown=tuple(unknown)))
        task = Task(**{name: _READ[kinds[name]](name, value) for name, value in given.items()})
        _check(task)
    except (ValueError, TypeError) as error:
        raise DimpleError("Task {number} of the experiment: {error}.", number=number, error=error) from None
    return task


def _check(task: Task) -> None:
    for what, holds in (
        ("kind must be rating or comparison", task.kind in ("rating", "comparison")),
        (Message("condition must be {conditions}", conditions=" or ".join(CONDITIONS)), task.condition in CONDITIONS),
        ("object must name a material", task.object != "" and task.object.isprintable()),  # it is on a line of the log
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
    if not math.isfinite(number := float(value)):
        raise ValueError(Message("{name} must be a number", name=name))
    return number


def _whole(name: str, value: Any) -> int:
    if not (number := _number(name, value)).is_integer():
        raise ValueError(Message("{name} must be a whole number", name=name))
    return int(number)


def _list(value: Any, mark: str | None) -> list[Any]:
    """Return the values of a list, or of a cell of a CSV."""
    return value.split(mark) if isinstance(value, str) else list(value)


_READ: Final[dict[str, Callable[[str, Any], Any]]] = {
    "str": lambda _, value: str(value).strip(),
    "int": _whole,
    "float": _number,
    "tuple[str, ...]": lambda _, value: tuple(str(each).strip() for each in _list(value, "|")),
    "tuple[float, ...]": lambda _, value: tuple(_number("a level", each) for each in _list(value, None)),
}
