"""How near the planner comes to the best choice: its fit made again, and its plans against a ladder of stand-ins.

Errors differ from press to press, so what is measured is measured twice, on HALF presses each that the planner does
not see, taken in turns. A candidate meets a tolerance when it does so on both halves; on one alone it may by luck. The
planner's own choice keeps to it when its error over all of them is at most SLACK times the tolerance. Costs are
compared as vertices x steps, which says what a choice costs on any machine, and as processor time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.base import TICK, DimpleError
from core.body.model import Model
from core.reduction.benchmark import DOWN, HOLD, Outcome, choose_presses, end_of, judge, press_variant
from core.reduction.planner import FEW, Plan, pace, plan
from core.reduction.proxy import mean_spacing, most_of

from .bodies import Body

HALF = 12  # presses: with a third as many the cheapest that meets a tolerance is often so by luck
SEED = 11  # of their places; the planner takes others
GROWTH = math.sqrt(2)  # of the vertices from rung to rung
FEWEST = 100  # vertices of the lowest rung
SLACK = 4 / 3
HEAVY = 0.6  # of the allowance that pays for presses of the mesh itself: half its vertices are pressed
NEVER = 0.0  # [s] a second: a budget that no mesh keeps to
LINE = 1.5  # times the work of the best that a choice may cost
NEAR = ((0.03, 0.10), (0.05, 0.20), (0.08, 0.30))  # tolerances: of the fingertip's radius, and of the force
FINEST, COARSEST = 0.3, 1.2  # spacings over the fingertip's radius that the fit goes by


@dataclass(frozen=True, kw_only=True)
class Tried:
    """Hold what a candidate came to on either half of the presses."""

    asked: int
    halves: tuple[Outcome, ...]

    @property
    def vertices(self) -> int:
        """Return how many move."""
        return self.halves[0].vertices

    @property
    def steps(self) -> int:
        """Return how many steps a tick takes."""
        return self.halves[0].steps

    @property
    def work(self) -> int:
        """Return vertices x steps of a tick."""
        return self.vertices * self.steps

    @cached_property
    def cost(self) -> float:
        """Return [s] of processor time for a second."""
        return float(np.mean([o.cost for o in self.halves]))

    @cached_property
    def error(self) -> float:
        """Return how far the skin is off [m], root of the mean square."""
        return float(np.sqrt(np.mean([o.error**2 for o in self.halves])))

    @cached_property
    def force_error(self) -> float:
        """Return how far the force is off, as a share."""
        return float(np.sqrt(np.mean([o.force_error**2 for o in self.halves])))

    def meets(self, tolerance: float, force_tolerance: float) -> bool:
        """Tell whether tolerances [m] and as a share are met on both halves."""
        return all(o.error <= tolerance and o.force_error <= force_tolerance for o in self.halves)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Hold a plan, what it came to, and the cheapest candidate that meets the tolerances.

    tolerance [m], force_tolerance: what was asked.  by: "presses", "heavy" or "fit".
    """

    body: Body
    tolerance: float
    force_tolerance: float
    budget: float
    by: str
    plan: Plan
    ours: Tried
    best: Tried

    @property
    def excess(self) -> float:
        """Return the larger error over its tolerance."""
        return max(self.ours.error / self.tolerance, self.ours.force_error / self.force_tolerance)

    @property
    def keeps(self) -> bool:
        """Tell whether the tolerances are kept, up to SLACK."""
        return self.excess <= SLACK

    @property
    def ratio(self) -> float:
        """Return the work over that of the best."""
        return self.ours.work / self.best.work

    @property
    def cost_ratio(self) -> float:
        """Return the processor time over that of the best."""
        return self.ours.cost / self.best.cost


class Judge:
    """Measure ways to simulate one body by presses that the planner does not see."""

    def __init__(self, body: Body, model: Model, *, half: int = HALF) -> None:
        self.body, self.model = body, model
        self._presses = choose_presses(model, body.radius, 2 * half, seed=SEED)
        _, _, self._goal = end_of(press_variant(model, self._presses, 0))
        self.mesh = self.tried(0)
        self._known = {0: self.mesh}

    def stand_in(self, vertices: int) -> Tried:
        """Return what a stand-in of so many vertices came to."""
        if vertices not in self._known:
            self._known[vertices] = self.tried(vertices)
        return self._known[vertices]

    def tried(self, asked: int) -> Tried:
        """Return what a proxy of so many vertices came to, 0 for the mesh; errors are inf where there is none."""
        try:
            proxy, steps, ends = None, self.model.substeps(TICK), self._goal
            if asked:
                proxy, steps, ends = end_of(press_variant(self.model, self._presses, asked))
        except DimpleError as error:
            return Tried(asked=asked, halves=(Outcome(asked=asked, note=str(error)),))
        parts = (slice(0, None, 2), slice(1, None, 2))
        halves = (judge(self.model, asked, proxy, steps, ends[part], self._goal[part]) for part in parts)
        return Tried(asked=asked, halves=tuple(halves))

    def ladder(self) -> list[Tried]:
        """Return every rung: stand-ins, then the mesh itself."""
        most = most_of(self.model)
        count = int(math.log(most / FEWEST, GROWTH)) + 1
        rungs = (self.stand_in(round(FEWEST * GROWTH**k)) for k in range(count))
        return [*(rung for rung in rungs if rung.vertices and math.isfinite(rung.error)), self.mesh]

    def judged(self, chosen: Plan, near: tuple[float, float], *, budget: float, by: str) -> Choice:
        """Measure a plan and find the best candidate, the plan's own among them."""
        ours = self.stand_in(chosen.asked)
        fit = [tried for tried in (*self.ladder(), ours) if tried.meets(*near)]
        return Choice(
            body=self.body, tolerance=near[0], force_tolerance=near[1], budget=budget, by=by, plan=chosen, ours=ours,
            best=min(fit, key=lambda tried: tried.work),
        )  # fmt: skip


def tolerances(body: Body) -> list[tuple[float, float]]:
    """Return what is asked of a body: [m] of the skin, and a share of the force."""
    return [(skin * body.radius, force) for skin, force in NEAR]


def choices(judge: Judge, *, budget: float, near: Sequence[tuple[float, float]] | None = None) -> Iterator[Choice]:
    """Plan one body for several tolerances, by presses of its mesh and as if that were too heavy to be pressed.

    Args:
        budget: [s] a second. NEVER: no mesh runs live, so that all is up to the planner.
    """
    for wanted in near or tolerances(judge.body):
        heavy = HEAVY * FEW * (DOWN + HOLD) * pace(judge.model)
        for by, allowance in (("presses", math.inf), ("heavy", heavy)):
            chosen = plan(
                judge.model, tolerance=wanted[0], force_tolerance=wanted[1], radius=judge.body.radius, budget=budget,
                allowance=allowance,
            )  # fmt: skip
            yield judge.judged(chosen, wanted, budget=budget, by=by)


def over_budgets(judge: Judge, budgets: Sequence[float]) -> Iterator[Choice]:
    """Plan one body by the fit for several budgets [s of a second], all for the middle one of the tolerances."""
    near = tolerances(judge.body)[1]
    for budget in budgets:
        chosen = plan(
            judge.model, tolerance=near[0], force_tolerance=near[1], radius=judge.body.radius, budget=budget,
            allowance=0.0,
        )  # fmt: skip
        yield judge.judged(chosen, near, budget=budget, by="fit")


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Hold a rung of a body: share is spacing over fingertip radius, error is over that radius too."""

    body: str
    vertices: int
    share: float
    error: float
    force_error: float


def rows(judge: Judge) -> list[Row]:
    """Return the rungs of a body that a fit goes by."""
    shares = {tried: mean_spacing(judge.model.mesh, tried.vertices) / judge.body.radius for tried in judge.ladder()}
    return [
        Row(
            body=judge.body.name, vertices=tried.vertices, share=share, error=tried.error / judge.body.radius,
            force_error=tried.force_error,
        )
        for tried, share in shares.items()
        if tried.asked and FINEST <= share <= COARSEST
    ]  # fmt: skip


def fit(found: Sequence[Row]) -> tuple[float, float, float, float]:
    """Return the planner's ERROR, ERROR_POWER, FORCE_ERROR and FORCE_POWER: least squares of the logarithms."""
    share = np.log([row.share for row in found])
    power, error = np.polyfit(share, np.log([row.error for row in found]), 1)
    force_power, force_error = np.polyfit(share, np.log([row.force_error for row in found]), 1)
    return float(np.exp(error)), float(power), float(np.exp(force_error)), float(force_power)
