"""How near the planner comes to the best choice: its fit repeated, and its plans against a ladder of proxies.

Errors differ from press to press, so each is measured twice, on two halves of HALF presses that the planner does not
see. A candidate meets a tolerance when it does so on both halves; on one alone that may be luck. The planner's own
choice meets a tolerance when its error over all presses is at most SLACK times as large. Costs are compared as
vertices x steps, which is the same on any machine, and as processor time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.base import TICK, DimpleError
from core.body.model import Model
from core.reduction.benchmark import Outcome, choose_presses, outcome_of, press_variant
from core.reduction.planner import Plan, plan
from core.reduction.proxy import mean_spacing, most_of
from core.steps import result_of

from .bodies import BodyCase

HALF = 12  # presses; with a third as many, the cheapest candidate that meets a tolerance often does so by luck
SEED = 11  # of their places; the planner takes others
GROWTH = math.sqrt(2)  # of the vertices from rung to rung
FEWEST = 100  # vertices of the lowest rung
SLACK = 4 / 3
NEVER = 0.0  # [s] per second: a budget that no mesh is within
LINE = 1.5  # a choice may cost so many times the work of the best
NEAR = ((0.03, 0.10), (0.05, 0.20), (0.08, 0.30))  # tolerances: of the fingertip's radius, and of the force
FINEST, COARSEST = 0.3, 1.2  # spacings over the fingertip's radius that are fitted


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A proxy, or the full mesh, and its outcomes on the two halves of the presses."""

    asked: int
    halves: tuple[Outcome, ...]

    @property
    def vertices(self) -> int:
        """Return the number of simulated vertices."""
        return self.halves[0].vertices

    @property
    def steps(self) -> int:
        """Return the steps per tick."""
        return self.halves[0].steps

    @property
    def work(self) -> int:
        """Return vertices x steps per tick."""
        return self.vertices * self.steps

    @cached_property
    def cost(self) -> float:
        """Return the processor time [s] per simulated second."""
        return float(np.mean([o.cost for o in self.halves]))

    @cached_property
    def error(self) -> float:
        """Return the root-mean-square error of the surface [m]."""
        return float(np.sqrt(np.mean([o.error**2 for o in self.halves])))

    @cached_property
    def force_error(self) -> float:
        """Return the error of the force, as a share."""
        return float(np.sqrt(np.mean([o.force_error**2 for o in self.halves])))

    def meets(self, tolerance: float, force_tolerance: float) -> bool:
        """Return whether the tolerances, [m] and a share of the force, are met on both halves."""
        return all(o.error <= tolerance and o.force_error <= force_tolerance for o in self.halves)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """A plan for one body, its measured outcome, and the cheapest candidate that meets the tolerances.

    body: what was planned.
    tolerance: of the surface [m].
    force_tolerance: of the force, as a share.
    budget: processor time [s] per simulated second.
    plan: the planner's choice.
    ours: that choice, measured.
    best: the cheapest candidate that meets the tolerances.
    """

    body: BodyCase
    tolerance: float
    force_tolerance: float
    budget: float
    plan: Plan
    ours: Candidate
    best: Candidate

    @property
    def excess(self) -> float:
        """Return the larger of the two errors over its tolerance."""
        return max(self.ours.error / self.tolerance, self.ours.force_error / self.force_tolerance)

    @property
    def keeps(self) -> bool:
        """Return whether the tolerances are met, up to SLACK."""
        return self.excess <= SLACK

    @property
    def ratio(self) -> float:
        """Return the work over that of the best."""
        return self.ours.work / self.best.work

    @property
    def cost_ratio(self) -> float:
        """Return the processor time over that of the best."""
        return self.ours.cost / self.best.cost


class ProxyBenchmark:
    """Proxies of one body, measured by presses that the planner does not see."""

    def __init__(self, body: BodyCase, model: Model, *, half: int = HALF) -> None:
        self.body, self.model = body, model
        self._presses = choose_presses(model, body.radius, 2 * half, seed=SEED)
        _, _, self._goal = result_of(press_variant(model, self._presses, 0))
        self.mesh = self._measured(0)
        self._known = {0: self.mesh}

    def proxy(self, vertices: int) -> Candidate:
        """Return the measured proxy of a number of vertices, the full mesh for 0; it is measured once.

        Where no such proxy can be made its errors are infinite.
        """
        if vertices not in self._known:
            self._known[vertices] = self._measured(vertices)
        return self._known[vertices]

    def _measured(self, asked: int) -> Candidate:
        try:
            proxy, steps, ends = None, self.model.substeps(TICK), self._goal
            if asked:
                proxy, steps, ends = result_of(press_variant(self.model, self._presses, asked))
        except DimpleError as error:
            return Candidate(asked=asked, halves=(Outcome(asked=asked, note=str(error)),))
        parts = (slice(0, None, 2), slice(1, None, 2))
        halves = (outcome_of(self.model, asked, proxy, steps, ends[part], self._goal[part]) for part in parts)
        return Candidate(asked=asked, halves=tuple(halves))

    def ladder(self) -> list[Candidate]:
        """Return every rung: proxies of growing size, then the full mesh."""
        most = most_of(self.model)
        count = int(math.log(most / FEWEST, GROWTH)) + 1
        rungs = (self.proxy(round(FEWEST * GROWTH**k)) for k in range(count))
        return [*(rung for rung in rungs if rung.vertices and math.isfinite(rung.error)), self.mesh]

    def rated(self, chosen: Plan, near: tuple[float, float], *, budget: float) -> Choice:
        """Measure a plan and find the best candidate, the plan's own proxy among them."""
        ours = self.proxy(chosen.asked)
        good = [candidate for candidate in (*self.ladder(), ours) if candidate.meets(*near)]
        return Choice(
            body=self.body, tolerance=near[0], force_tolerance=near[1], budget=budget, plan=chosen, ours=ours,
            best=min(good, key=lambda candidate: candidate.work),
        )  # fmt: skip


def tolerances(body: BodyCase) -> list[tuple[float, float]]:
    """Return the pairs of tolerances that a body is planned for: of the surface [m], and a share of the force."""
    return [(skin * body.radius, force) for skin, force in NEAR]


def choices(
    benchmark: ProxyBenchmark, *, budget: float, near: Sequence[tuple[float, float]] | None = None
) -> Iterator[Choice]:
    """Plan one body for several tolerances.

    Args:
        budget: processor time [s] per simulated second. With NEVER no mesh runs live, so the planner must choose.
        near: pairs of tolerances, those of `tolerances` where None.
    """
    for wanted in near or tolerances(benchmark.body):
        chosen = plan(
            benchmark.model, tolerance=wanted[0], force_tolerance=wanted[1], radius=benchmark.body.radius, budget=budget
        )
        yield benchmark.rated(chosen, wanted, budget=budget)


def over_budgets(benchmark: ProxyBenchmark, budgets: Sequence[float]) -> Iterator[Choice]:
    """Plan one body by the fit for several budgets [s per second], for the middle pair of the tolerances."""
    near = tolerances(benchmark.body)[1]
    for budget in budgets:
        chosen = plan(
            benchmark.model, tolerance=near[0], force_tolerance=near[1], radius=benchmark.body.radius, budget=budget
        )
        yield benchmark.rated(chosen, near, budget=budget)


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One rung of a body.

    body: its name.
    vertices: simulated vertices.
    share: spacing of the proxy over the fingertip's radius.
    error: of the surface, over the fingertip's radius.
    force_error: of the force, as a share.
    """

    body: str
    vertices: int
    share: float
    error: float
    force_error: float


def rows(benchmark: ProxyBenchmark) -> list[Row]:
    """Return the rungs of a body that are fitted."""
    shares = {
        rung: mean_spacing(benchmark.model.mesh, rung.vertices) / benchmark.body.radius for rung in benchmark.ladder()
    }
    return [
        Row(
            body=benchmark.body.name, vertices=rung.vertices, share=share, error=rung.error / benchmark.body.radius,
            force_error=rung.force_error,
        )
        for rung, share in shares.items()
        if rung.asked and FINEST <= share <= COARSEST
    ]  # fmt: skip


def fit(found: Sequence[Row]) -> tuple[float, float, float, float]:
    """Return the planner's ERROR, ERROR_POWER, FORCE_ERROR and FORCE_POWER: least squares of the logarithms."""
    share = np.log([row.share for row in found])
    power, error = np.polyfit(share, np.log([row.error for row in found]), 1)
    force_power, force_error = np.polyfit(share, np.log([row.force_error for row in found]), 1)
    return float(np.exp(error)), float(power), float(np.exp(force_error)), float(force_power)
