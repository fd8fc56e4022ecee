"""`dev.py core experiment`: the sensory comparison of chapter 5, with simulated observers or the answers in a file.

Observers of known point of equality and just-noticeable difference go through the whole experiment: plan, order,
answers, log, fit. psignifit, where it is installed, fits some of them too. Nothing here stands for a person.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from importlib import util
from pathlib import Path

import numpy as np

from core.base import DimpleError
from core.experiment.log import CUT, Log, Row, read_rows
from core.experiment.plan import ExperimentPlan, Trial, make_plan
from core.experiment.run import Experiment
from studies.experiment_results import Comparison, Ratings, compared, rated, sentences
from studies.psychometric import QUARTER, Psychometric, shares

LEVELS = [0.55, 0.65, 0.75, 0.85, 0.95, 1.05, 1.15, 1.25, 1.35, 1.45]
OBJECTS = ("Object 1", "Object 2", "Object 3")
PEOPLE = 8  # as many as the paper asked
REFEREED = 50  # observers that psignifit fits too: it takes seconds for each
KILLS = 10
PLAN = {
    "name": "simulated", "seed": 5,
    "tasks": [
        {"kind": "comparison", "method": "constant", "object": "Object 2", "levels": LEVELS, "repeats": 24},
        {"kind": "comparison", "method": "staircase", "object": "Object 3", "repeats": 160, "start": 1.4, "step": 0.08},
    ],
}  # fmt: skip
RATING = {
    "name": "ratings", "seed": 5,
    "tasks": [{"kind": "rating", "object": name, "repeats": 3} for name in OBJECTS],
}  # fmt: skip
LIKENESS = {"Object 1": 2.6, "Object 2": 3.1, "Object 3": 2.9}  # of the simulated raters, made up


@dataclass(frozen=True, slots=True)
class Observer:
    """A simulated observer.

    pse, jnd: factors on the stiffness.
    lapse: share of answers at random, on each side.
    dice: of its answers.
    """

    pse: float
    jnd: float
    lapse: float
    dice: random.Random

    def answer(self, trial: Trial) -> int:
        """Answer a trial as a person would: from 1 on."""
        if trial.task.kind == "rating":
            felt = self.dice.gauss(LIKENESS[trial.task.object], 0.7)
            return min(max(round(felt), 1), len(trial.task.steps))
        stiffer = self.dice.random() < float(shares(np.array(trial.level), self.pse, self.jnd / QUARTER, self.lapse))
        return 1 if stiffer == trial.test_first else 2


def add_experiment(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_experiment)
    what = command.add_mutually_exclusive_group(required=True)
    what.add_argument("--simulate", type=int, metavar="N", help="simulate N observers")
    what.add_argument("--analyse", type=Path, nargs="+", metavar="CSV", help="files of answers")
    what.add_argument("--observe", type=Path, metavar="CSV", help="one simulated observer, answers kept in a file")
    command.add_argument("--seed", type=int, default=1)
    command.add_argument("--referee", type=int, default=REFEREED, metavar="N", help="have psignifit fit N of them too")
    command.add_argument("--json", type=Path, metavar="OUT", help="write the figures")
    command.add_argument("--plot", type=Path, metavar="OUT.png", help="draw answers and ratings")


def run_experiment(options: argparse.Namespace) -> int:
    """Simulate, or analyse."""
    if options.observe:
        observe(make_plan(PLAN), options.observe, options.seed)
        return 0
    if options.analyse:
        try:
            rows = [row for path in options.analyse for row in read_rows(path)]
        except OSError as error:
            raise DimpleError(f"The answers cannot be read: {error}.") from None
        print("\n".join(sentences(rows)) or "There are no answers yet.")
        if options.plot:
            draw(rated(rows), compared(rows), options.plot, simulated=False)
        return 0
    figures, comparisons = simulate(options.simulate, seed=options.seed, referee=options.referee)
    figures |= killed(options.seed)
    ratings = simulated_ratings(options.seed)
    for name, value in figures.items():
        print(f"{name:<22} {value:.6g}")
    if options.json:
        try:
            options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            raise DimpleError(f"{options.json} cannot be written: {error.strerror}.") from None
    if options.plot:
        draw(ratings, comparisons, options.plot, simulated=True)
    return 0


def observer(dice: random.Random) -> Observer:
    """Return an observer at random."""
    return Observer(dice.uniform(0.88, 1.12), dice.uniform(0.08, 0.18), dice.uniform(0.0, 0.03), dice)


def go_through(plan: ExperimentPlan, who: Observer, path: Path, participant: str, *, sync: bool) -> Experiment:
    """Answer all that is left of an experiment."""
    experiment = Experiment(plan, participant, Log(path, sync=sync))
    while trial := experiment.next():
        experiment.answer(who.answer(trial), samples=[(0.0, 0.001, 0.5), (0.1, 0.002, 1.0)] if sync else ())
    return experiment


def simulate(count: int, *, seed: int = 1, referee: int = 0) -> tuple[dict[str, float], list[Comparison]]:
    """Return the figures of so many observers, and the comparisons of the last."""
    plan, dice = make_plan(PLAN), random.Random(seed)
    inside: dict[str, list[bool]] = {f"{m}_{w}": [] for m in ("constant", "staircase") for w in ("pse", "jnd")}
    errors: dict[str, list[float]] = {"pse": [], "jnd": [], "pse_as_it_comes": [], "jnd_as_it_comes": []}
    comparisons: list[Comparison] = []
    with tempfile.TemporaryDirectory(prefix="dimple-") as folder:
        for i in range(count):
            who = observer(dice)
            path = Path(folder) / f"{i}.csv"
            comparisons = compared(go_through(plan, who, path, str(i), sync=False).log.rows)
            path.unlink()
            for method, each in zip(("constant", "staircase"), comparisons, strict=True):
                fitted = each.fitted
                for what, true in (("pse", who.pse), ("jnd", who.jnd)):
                    low, high = getattr(fitted, f"{what}_95", (math.nan, math.nan))
                    inside[f"{method}_{what}"].append(low <= true <= high)
            for each in comparisons if i < referee else ():
                tails = ("", "_as_it_comes") if each is comparisons[0] else ("",)  # that takes minutes for many levels
                for tail in tails:
                    judged = by_psignifit(each, as_it_comes=bool(tail))
                    for what in ("pse", "jnd") if judged and isinstance(each.fitted, Psychometric) else ():
                        errors[what + tail].append(abs(getattr(each.fitted, what) / judged[what] - 1))
    figures = {"observers": float(count), "coverage": float(np.mean(inside["constant_pse"] + inside["constant_jnd"]))}
    figures |= {f"coverage_{name}": float(np.mean(each)) for name, each in inside.items()}
    for what, found in errors.items():
        if found:
            name, _, tail = what.partition("_")
            name += "_error" + (f"_{tail}" if tail else "")
            figures |= {name: max(found), f"{name}_median": float(np.median(found)), f"{name}_fits": float(len(found))}
    return figures, comparisons


def by_psignifit(each: Comparison, *, as_it_comes: bool = False) -> dict[str, float]:
    """Return PSE and JND by psignifit, nothing where it is not installed.

    Both take the maximum of the posterior, and the lapses of both sides for one number with a prior of Beta(1, 10) for
    each side.

    Args:
        as_it_comes: with psignifit's other priors too, which keep the width within the levels, and answers that
            scatter more than a binomial's; else, as ours, without.
    """
    if util.find_spec("psignifit") is None:
        return {}
    import psignifit

    data = np.array([each.levels, each.stiffer, each.trials]).T
    ours = {} if as_it_comes else {
        "fixed_parameters": {"eta": 1e-9}, "priors": {"threshold": np.ones_like, "width": np.ones_like},
    }  # fmt: skip
    result = psignifit.psignifit(
        data, experiment_type="equal asymptote", sigmoid="norm", estimate_type="MAP", verbose=False, **ours
    )
    found = result.parameter_estimate
    ninety = 2 * 1.6448536269514722  # standard deviations from 5 to 95 %
    return {"pse": found["threshold"], "jnd": found["width"] / ninety * QUARTER}


def observe(plan: ExperimentPlan, path: Path, seed: int) -> None:
    """Let one observer answer, each trial with a seed of its own: an interrupted one goes on as it would have."""
    experiment = Experiment(plan, str(seed), Log(path))
    while trial := experiment.next():
        who = observer(random.Random(seed))
        who.dice.seed(f"{seed} {trial.number}")
        samples = [(0.01 * i, 1e-4 * i, 0.1 * i) for i in range(20)]
        experiment.answer(who.answer(trial), seconds=1.0, samples=samples)
        time.sleep(0.002)


def killed(seed: int, kills: int = KILLS) -> dict[str, float]:
    """Kill an observer's program at so many moments; return what was lost or is there twice."""
    plan, dice = make_plan(PLAN), random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="dimple-") as name:
        path, whole, done = Path(name) / "killed.csv", Path(name) / "whole.csv", 0
        words = [sys.executable, "-m", "studies", "experiment", "--seed", str(seed), "--observe"]
        while done < kills:
            before = len(path.read_bytes().splitlines()) if path.exists() else 0
            process = subprocess.Popen([*words, str(path)], cwd=Path(__file__).parents[1])
            grown = before + dice.randint(2, 30)  # moments are counted in rows: computers differ
            while process.poll() is None and (not path.exists() or len(path.read_bytes().splitlines()) < grown):
                time.sleep(0.001)
            time.sleep(dice.uniform(0, 0.005))
            if process.poll() is None:
                process.kill()
                done += 1
            process.wait()
        with path.open("ab") as file:
            file.write(b"17,half a ro")
        observe(plan, path, seed)
        observe(plan, whole, seed)
        mine, all_of_it = Log(path).rows, Log(whole).rows
        answers = [[(row.trial, row.level, row.response) for row in rows] for rows in (mine, all_of_it)]
        touches = [touched(path, mine), touched(whole, all_of_it)]
        doubled = len(mine) - len({row.trial for row in mine})
        lost = sum(a != b for a, b in zip(*answers, strict=False)) + abs(len(mine) - len(all_of_it))
        return {
            "killed": float(kills), "lost": float(lost), "doubled": float(doubled),
            "touch_rows_off": float(abs(touches[0] - touches[1])),
        }  # fmt: skip


def touched(path: Path, rows: list[Row]) -> int:
    """Return how many samples of touch belong to the answers of a file."""
    answered = {f"{row.trial},{row.time}" for row in rows}
    lines = path.with_name(f"{path.stem}_touch.csv").read_text().splitlines()
    return sum(",".join(line.split(",")[:2]) in answered and not line.endswith(CUT) for line in lines)


def simulated_ratings(seed: int) -> list[Ratings]:
    """Return the ratings of as many simulated people as the paper asked."""
    plan, rows = make_plan(RATING), []
    with tempfile.TemporaryDirectory(prefix="dimple-") as folder:
        for i in range(PEOPLE):
            who = observer(random.Random(seed + i))
            rows += go_through(plan, who, Path(folder) / f"{i}.csv", str(i), sync=False).log.rows
    return rated(rows)


def draw(ratings: list[Ratings], comparisons: list[Comparison], path: Path, *, simulated: bool) -> None:
    """Draw ratings as in the paper's Fig. 9, and the psychometric functions.

    Raises:
        DimpleError: matplotlib is not installed, or the file cannot be written.
    """
    if util.find_spec("matplotlib") is None:
        raise DimpleError("--plot needs matplotlib, which is not installed here. Everything else works without it.")
    from matplotlib.figure import Figure

    panels = bool(ratings) + len(comparisons)
    figure = Figure(figsize=(4.5 * max(panels, 1), 4), layout="constrained")
    axes = list(figure.subplots(1, max(panels, 1), squeeze=False)[0])
    if ratings:
        _draw_ratings(axes.pop(0), ratings)
    for each, axis in zip(comparisons, axes, strict=True):
        _draw_comparison(axis, each)
    if simulated:
        figure.suptitle("Simulated observers: no person was asked")
    try:
        figure.savefig(path, dpi=130)
    except (OSError, ValueError) as error:
        raise DimpleError(f"{path} cannot be written: {error}.") from None


def _draw_ratings(axis, ratings: list[Ratings]) -> None:  # type: ignore[no-untyped-def]
    names = [f"{each.object}\n({each.condition})" for each in ratings]
    below = np.zeros(len(ratings))
    steps = max(len(each.counts) for each in ratings)
    for step in range(steps):
        share = np.array([100 * each.counts[step] / sum(each.counts) for each in ratings])
        axis.bar(names, share, bottom=below, color=str(0.9 - 0.7 * step / (steps - 1)), label=f"{step + 1}")
        below += share
    axis.set(ylabel="answers (%)", title="Like the real object? 1 different, 4 the same")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=steps, frameon=False)


def _draw_comparison(axis, each: Comparison) -> None:  # type: ignore[no-untyped-def]
    x, n = np.array(each.levels), np.array(each.trials)
    axis.scatter(x, np.array(each.stiffer) / n, s=8 + 40 * n / n.max(), color="0.3")
    fitted = each.fitted
    if isinstance(fitted, Psychometric):
        line = np.linspace(x.min(), x.max(), 200)
        axis.plot(line, shares(line, fitted.pse, fitted.jnd / QUARTER, fitted.lapse), color="tab:blue")
        axis.axvspan(*fitted.pse_95, color="tab:blue", alpha=0.2, lw=0)
        axis.axvline(fitted.pse, color="tab:blue", lw=1)
    title = f"{each.object} ({each.condition}), participant {each.participant}"
    axis.set(xlabel="times its stiffness", ylabel="judged the stiffer", ylim=(-0.02, 1.02), title=title)
