"""How near the planner comes to the best choice: its fit repeated, and its plans against a ladder of proxies.

A press keeps the tolerances when the errors of its dent and of its force are within them, and a candidate keeps them
when all presses but one in 50 do. The best is the lowest rung of the ladder that does. The presses are others than any
that the planner was fitted to. Costs are compared as vertices x steps, which is the same on any machine, and as
processor time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from core.base import TICK, DimpleError, Floats
from core.body.model import Model
from core.reduction.benchmark import choose_presses, outcome_of, press_variant
from core.reduction.error_model import COARSE, spread_of
from core.reduction.planner import Plan, plan
from core.reduction.proxy import mean_spacing, most_of
from core.steps import result_of

from .bodies import BodyCase

PRESSES, JUDGED = 24, 72  # of a body that is fitted, and of one that choices are judged by: one in 50 of 24 is luck
SEED = 11  # of their places
GROWTH = 2**0.25  # of the vertices from rung to rung
FEWEST = 100  # vertices of the lowest rung
KEPT = 0.98  # of the presses
NEVER = 0.0  # [s] per second: a budget that no mesh is within
LINE = 1.5  # a choice may cost so many times the work of the best
NEAR = ((0.03, 0.10), (0.05, 0.20), (0.08, 0.30))  # tolerances: of the fingertip's radius, and of the force
FINEST, COARSEST = 0.3, 1.2  # spacings over the fingertip's radius that are fitted


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A proxy, or the full mesh, and what presses found.

    asked: vertices the proxy was requested with, 0 for the full mesh.
    vertices: simulated vertices, 0 where no such proxy can be made.
    steps: per tick.
    cost: processor time [s] per simulated second.
    errors: (p,) of the surface over the dent, press by press [m].
    force_errors: (p,) as a share of each press's force.
    """

    asked: int
    vertices: int = 0
    steps: int = 0
    cost: float = math.inf
    errors: Floats = field(default_factory=lambda: np.array([math.inf]))
    force_errors: Floats = field(default_factory=lambda: np.array([math.inf]))

    @property
    def work(self) -> int:
        """Return vertices x steps per tick."""
        return self.vertices * self.steps

    def excess(self, near: tuple[float, float]) -> Floats:
        """Return the larger of the two errors of each press (p,) over its tolerance."""
        return np.maximum(self.errors / near[0], self.force_errors / near[1])

    def meets(self, near: tuple[float, float]) -> bool:
        """Return whether the tolerances, [m] and a share of the force, are kept by all presses but one in 50."""
        return bool(np.quantile(self.excess(near), KEPT) <= 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """A plan for one body, its measured outcome, and the cheapest candidate that meets the tolerances.

    body: what was planned.
    near: tolerances, of the surface [m] and of the force, as a share.
    plan: the planner's choice.
    ours: that choice, measured.
    best: the cheapest candidate that meets the tolerances.
    """

    body: BodyCase
    near: tuple[float, float]
    plan: Plan
    ours: Candidate
    best: Candidate

    @property
    def missed(self) -> int:
        """Return how many presses do not keep the tolerances."""
        return int((self.ours.excess(self.near) > 1).sum())

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

    def __init__(self, body: BodyCase, model: Model, *, presses: int = PRESSES) -> None:
        self.body, self.model = body, model
        self._presses = choose_presses(model, body.radius, presses, seed=SEED)
        _, _, self._goal = result_of(press_variant(model, self._presses, 0))
        self._known: dict[int, Candidate] = {}
        self.mesh = self.proxy(0)

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
        except DimpleError:
            return Candidate(asked=asked)
        each = [
            outcome_of(self.model, asked, proxy, steps, [end], [wanted])
            for end, wanted in zip(ends, self._goal, strict=True)
        ]
        return Candidate(
            asked=asked, vertices=ends[0].positions.shape[1], steps=steps, cost=float(np.mean([o.cost for o in each])),
            errors=np.array([o.error for o in each]), force_errors=np.array([o.force_error for o in each]),
        )  # fmt: skip

    def ladder(self, growth: float = GROWTH) -> Iterator[Candidate]:
        """Yield every rung: proxies of growing size, then the full mesh."""
        count = int(math.log(most_of(self.model) / FEWEST, growth)) + 1
        rungs = (self.proxy(round(FEWEST * growth**k)) for k in range(count))
        yield from (rung for rung in rungs if rung.vertices)
        yield self.mesh

    def rated(self, chosen: Plan, near: tuple[float, float]) -> Choice:
        """Measure a plan and find the best candidate, the plan's own proxy among them."""
        ours = self.proxy(chosen.asked)
        best = next(rung for rung in self.ladder() if rung.meets(near))
        return Choice(
            body=self.body, near=near, plan=chosen, ours=ours,
            best=ours if ours.meets(near) and ours.work < best.work else best,
        )  # fmt: skip


def tolerances(body: BodyCase) -> list[tuple[float, float]]:
    """Return the pairs of tolerances that a body is planned for: of the surface [m], and a share of the force."""
    return [(skin * body.radius, force) for skin, force in NEAR]


def choices(benchmark: ProxyBenchmark, near: Sequence[tuple[float, float]] | None = None) -> Iterator[Choice]:
    """Plan one body for several tolerances, as if no mesh ran live, so that the planner must choose.

    Args:
        near: pairs of tolerances, those of `tolerances` where None.
    """
    for wanted in near or tolerances(benchmark.body):
        chosen = plan(
            benchmark.model, tolerance=wanted[0], force_tolerance=wanted[1], radius=benchmark.body.radius, budget=NEVER
        )
        yield benchmark.rated(chosen, wanted)


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One rung of a body.

    body: its name.
    vertices: simulated vertices.
    share: spacing of the proxy over the fingertip's radius.
    spread: of a dent, over the fingertip's radius.
    error: of the surface that all presses but one in 50 stay below, over the fingertip's radius.
    force_error: the same of the force, as a share.
    """

    body: str
    vertices: int
    share: float
    spread: float
    error: float
    force_error: float


def rows(benchmark: ProxyBenchmark) -> list[Row]:
    """Return the rungs of a body that are fitted: every second one."""
    radius, mesh = benchmark.body.radius, benchmark.model.mesh
    found = [
        Row(
            body=benchmark.body.name, vertices=rung.vertices, share=mean_spacing(mesh, rung.vertices) / radius,
            spread=spread_of(benchmark.model) / radius, error=float(np.quantile(rung.errors, KEPT)) / radius,
            force_error=float(np.quantile(rung.force_errors, KEPT)),
        )
        for rung in benchmark.ladder(GROWTH**2)
        if rung.asked
    ]  # fmt: skip
    return [row for row in found if FINEST <= row.share <= COARSEST]


def fit(found: Sequence[Row]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the planner's ERROR and FORCE_ERROR: least squares of the logarithms, on either side of COARSE."""
    log = np.log([(row.share, row.spread, row.error, row.force_error) for row in found])
    coarse = log[:, 0] > math.log(COARSE)
    share, spread, error, force_error = log[~coarse].T
    one = np.ones(len(share))
    (factor, *powers), *_ = np.linalg.lstsq(np.column_stack([one, share, spread]), error, rcond=None)
    (force_factor, force_power), *_ = np.linalg.lstsq(np.column_stack([one, share]), force_error, rcond=None)
    beyond = log[coarse, 0] - math.log(COARSE)
    more = log[coarse, 3] - (force_factor + force_power * math.log(COARSE))
    coarse_power = float(more @ beyond / (beyond @ beyond))
    return (math.exp(factor), *map(float, powers)), (math.exp(force_factor), float(force_power), coarse_power)
