"""`dev.py core experiment`: plans for the sensory comparison of chapter 5, simulated participants, and the analysis.

Participants who are simulated go through the whole experiment: plan, order, answers, log, fit. Nothing here stands
for a person.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.base import DimpleError
from core.everyday_presets import OBJECTS
from core.experiment.plan_file import Plan, Stimulus, Trial, read_plan
from core.experiment.run import Experiment
from studies.experiment.counterbalanced_plans import KINDS, make
from studies.experiment.results import QUARTER, Pairs, Ratings, group, read, summary, totals
from studies.files import new_figure, save_picture

PEOPLE = 8  # as many as the paper asked
PSE, PSE_SPREAD = 1.03, 0.08  # of the simulated people: mean, and standard deviation between them
JND, JND_SPREAD = 0.12, 0.3  # geometric mean, and standard deviation of the logarithm
NOISE = 0.6  # steps by which a simulated rating scatters
STRICT = 5.0  # steps of a rating that a factor of e on the stiffness costs
MANNERS = ("good", "good", "good", "good", "swapped", "guessing", "lapsing", "one button")
LAPSING = 0.12  # share of answers at random
MATERIALS = {each.name: each.material for each in OBJECTS}


@dataclass(slots=True)
class Person:
    """A simulated participant: how they answer, point of equality and just-noticeable difference, and their dice."""

    manner: str
    pse: float
    jnd: float
    dice: random.Random

    def answer(self, plan: Plan, trial: Trial) -> int:
        """Answer a trial, from 1 on."""
        steps = len(plan.answers)
        if self.manner == "guessing" or (self.manner == "lapsing" and self.dice.random() < LAPSING):
            return self.dice.randint(1, steps)
        if self.manner == "one button":
            return 1
        stiff = [self.felt(plan, each) for each in trial.show]
        if plan.made["kind"] == "rating":
            rated = steps - STRICT * abs(math.log(stiff[0] / stiff[1])) + self.dice.gauss(0, NOISE)
            chosen = min(max(round(rated), 1), steps)
        else:
            chosen = 1 if stiff[0] + self.dice.gauss(0, self.jnd / QUARTER) > stiff[1] else 2
        return steps + 1 - chosen if self.manner == "swapped" else chosen

    def felt(self, plan: Plan, stimulus: Stimulus) -> float:
        """Return how stiff a stimulus is to them: the standard as stiff as the test at their point of equality."""
        if plan.made["kind"] == "rating":
            level = 1.0 if stimulus.real else stimulus.level
            return level * MATERIALS[plan.objects[stimulus.real or stimulus.object]].K1
        return self.pse if stimulus.real or stimulus.object == plan.made["standard"] else stimulus.level


def person(manner: str, dice: random.Random) -> Person:
    """Return a participant at random."""
    return Person(manner, dice.gauss(PSE, PSE_SPREAD), math.exp(dice.gauss(math.log(JND), JND_SPREAD)), dice)


def add_experiment(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_experiment)
    what = command.add_mutually_exclusive_group(required=True)
    what.add_argument("--plan", choices=KINDS, help="write a plan to --out")
    what.add_argument("--simulate", type=Path, metavar="PLAN.json", help="let simulated people take part, into --out")
    what.add_argument("--analyse", type=Path, nargs="+", metavar="CSV", help="files of answers; they are only read")
    command.add_argument("--out", type=Path, help="file of the plan, or folder of the simulated answers")
    command.add_argument("--participants", type=int, default=PEOPLE, metavar="N")
    command.add_argument("--objects", nargs="+", default=[], metavar="NAME", help="presets or materials of the plan")
    command.add_argument("--real", action="store_true", help="the standard of a pair is the real object")
    command.add_argument("--seed", type=int, default=1)
    command.add_argument("--plot", type=Path, metavar="OUT.png", help="draw ratings and psychometric functions")


def run_experiment(options: argparse.Namespace) -> int:
    """Write a plan, simulate, or analyse."""
    if not options.out and not options.analyse:
        raise DimpleError("--plan and --simulate need --out.")
    if options.plan:
        plan = make(
            options.plan, participants=options.participants, seed=options.seed, objects=options.objects,
            real=options.real,
        )  # fmt: skip
        with options.out.open("x", encoding="utf-8") as file:  # never over a plan that is in use
            file.write(written(plan))
        return 0
    people, paths = dict[str, Person](), options.analyse
    if options.simulate:
        people, paths = simulate(read_plan(options.simulate), options.out, options.seed)
    pairs, ratings, notes = read(paths)
    lines = {each.participant: each.sentence() for each in pairs}
    lines |= {each.participant: each.sentence() for each in ratings}
    for code, line in lines.items():
        truth = people.get(code)
        print((f"{truth.manner:<10} true {truth.pse:.3f}, {truth.jnd:.1%} | " if truth else "") + line)
    print("\n".join([*summary(pairs, ratings), *notes]))
    if options.plot:
        draw(pairs, ratings, options.plot, simulated=bool(people))
    return 0


def written(plan: dict[str, object]) -> str:
    """Return a plan as the text of its file, a trial a line."""
    people = plan["participants"]
    assert isinstance(people, dict)
    lists = (f'"{code}": [\n' + ",\n".join(map(json.dumps, trials)) + "\n]" for code, trials in people.items())
    whole = '"participants": {\n' + ",\n".join(lists) + "\n}"
    return json.dumps({**plan, "participants": {}}, indent=1).replace('"participants": {}', whole) + "\n"


def simulate(plan: Plan, folder: Path, seed: int) -> tuple[dict[str, Person], list[Path]]:
    """Let people take part; return them and their files."""
    folder.mkdir(parents=True, exist_ok=True)
    people, paths = {}, []
    for i, code in enumerate(plan.participants):
        people[code] = person(MANNERS[i % len(MANNERS)], random.Random(f"{seed} {code}"))
        paths.append(folder / f"{code}.csv")
        take_part(plan, code, paths[-1], people[code].answer)
    return people, paths


def take_part(plan: Plan, code: str, path: Path, answer: Callable[[Plan, Trial], int], *, pause_s: float = 0.0) -> None:
    """Answer all that is left of an experiment."""
    materials = {label: MATERIALS[name] for label, name in plan.objects.items()}
    experiment = Experiment(plan, code, path, materials, {"device": "simulated"})
    experiment.agree()
    while trial := experiment.trial:
        for _ in trial.show:
            experiment.begin()
            experiment.intervals[-1].feel([(0.001 * i, *(0.0,) * 18) for i in range(20)], math.inf)
            experiment.intervals[-1].seconds = plan.exposure_s
        experiment.answer(answer(plan, trial))
        time.sleep(pause_s)
    experiment.log.file.close()


def draw(pairs: Sequence[Pairs], ratings: Sequence[Ratings], path: Path, *, simulated: bool) -> None:
    """Draw ratings as the paper's Fig. 9 counts them, and points of equality and just-noticeable differences.

    Raises:
        DimpleError: matplotlib is not installed, or writes no such picture.
    """
    figure = new_figure(9 * bool(ratings) + 11 * bool(pairs), 4.2)
    axes = list(figure.subplots(1, bool(ratings) + 2 * bool(pairs), squeeze=False)[0])
    if ratings:
        _draw_ratings(axes.pop(0), [each for each in ratings if not each.refused])
    if pairs:
        _draw_pairs(axes, pairs)
    if simulated:
        figure.suptitle("Simulated participants: no person was asked")
    save_picture(figure, path)


def _draw_ratings(axis, ratings: Sequence[Ratings]) -> None:  # type: ignore[no-untyped-def]
    rows = [(f"{real}\n{virtual} x {level:g}", counts) for (real, virtual, level), counts in totals(ratings).items()]
    below = np.zeros(len(rows))
    names = [f"{name}\nn = {sum(counts.values())}" for name, counts in rows]
    steps = ratings[0].steps if ratings else []
    for i, step in enumerate(steps):
        share = np.array([100 * counts[step] / sum(counts.values()) for _, counts in rows])
        axis.bar(names, share, bottom=below, color=str(0.9 - 0.7 * i / (len(steps) - 1)), label=step)
        below += share
    axis.set(ylabel="answers (%)", title=f"Like the real object? {len(ratings)} participants")
    axis.tick_params(axis="x", labelsize=7)
    axis.set_xlabel("real object, constants of the virtual one, answers")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=4, frameon=False)


def _draw_pairs(axes, pairs: Sequence[Pairs]) -> None:  # type: ignore[no-untyped-def]
    fitted = [each for each in pairs if not each.refused]
    for axis, name, label in zip(axes, ("pse", "jnd"), ("point of equality", "just noticeable"), strict=True):
        values = [getattr(each, name) for each in fitted]
        for i, (each, value) in enumerate(zip(fitted, values, strict=True)):
            low, high = getattr(each, f"{name}_95")
            axis.plot([low, high], [i, i], color="0.6")
            axis.plot(value, i, "o", color="0.2")
        logs = group([math.log(value) for value in values]) if name == "jnd" else ()
        mean, low, high = (math.exp(each) for each in logs) if logs else group(values)
        axis.axvspan(low, high, color="tab:blue", alpha=0.2, lw=0)
        axis.axvline(mean, color="tab:blue")
        of = f"{len(fitted)} of {len(pairs)} participants; group in blue"
        axis.set(xlabel=f"{label} (share of the standard)", title=of)
        axis.set_yticks(range(len(fitted)), [each.participant for each in fitted])
