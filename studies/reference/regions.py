"""Parts of a pinned body that rest: they are not stepped until something moves beside them.

A region is awake while a vertex of it, or of one beside it, has gone beyond the slack within the last REGION_TIME,
or may meet a fingertip. One that falls asleep stays where it is, without a speed, and pulls on those beside it as ever.
All wake where the pressure would carry the surface farther than the slack, by K1 alone, or a change may.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from core.base import Bools, Floats, Ints
from core.body.model import Model, State
from core.body.regions import Regions
from core.body.shape_matching import Pose

REGION_TIME = 0.1  # [s]


@dataclass(slots=True)
class Awake:
    """Which regions of a body are awake.

    regions: what rests and wakes together.
    clock: [s].
    moved: (k,) when a region last went beyond the slack [s].
    vertices: (n,) that are awake.
    settled: (3, n) where they were when they last went beyond it [m].
    pressure: that what rests has settled under [Pa].
    changed: what is displaced is to wake.
    """

    regions: Regions
    clock: float = 0.0
    moved: Floats = field(default_factory=lambda: np.zeros(0))
    vertices: Bools = field(default_factory=lambda: np.zeros(0, bool))
    settled: Floats = field(default_factory=lambda: np.zeros((3, 0)))
    pressure: float = 0.0
    changed: bool = True

    def __post_init__(self) -> None:
        self.moved = np.full(len(self.regions.starts) - 1, -np.inf)
        self.vertices = np.ones(len(self.regions.of), bool)
        self.settled = np.zeros((3, len(self.regions.of)))

    def choose(self, model: Model, state: State, noted: Ints, *, led: bool) -> Model:
        """Return the model of a tick that begins, in which what sleeps does not move.

        Args:
            noted: vertices that fingertips may meet.
            led: pins are, or the shape at rest.
        """
        regions, x = self.regions, state.positions
        bulge = 0.0
        if model.pressure.fill != "none":
            area = float(model.mesh.triangle_areas.sum())
            bulge = abs(state.pressure - self.pressure) * area / max(float(model.matching.k1.sum()), 1e-300)
        pushed = self.changed and bool(model.pressure.rest_pressure or model.gravity.any())
        if (
            pushed or led or bulge > regions.slack or model.free or not model.matching.k1.any()
            or model.ground is not None
        ):  # fmt: skip
            self.moved[:], self.pressure = self.clock, state.pressure
        elif self.changed:
            self._note(_beyond(x, _placed(model.matching.rest, state.pose), regions.slack))
        self.changed = False
        self.moved[regions.of[noted]] = self.clock
        wanted = np.zeros(len(self.moved), bool)
        for k in np.flatnonzero(self.clock - self.moved < REGION_TIME):
            wanted[regions.beside[regions.starts[k] : regions.starts[k + 1]]] = True
        before, self.vertices = self.vertices, wanted[regions.of]
        woken = self.vertices & ~before
        self.settled[:, woken] = x[:, woken]
        state.velocities[:, before & ~self.vertices] = 0.0
        return replace(model, inverse_mass=np.where(self.vertices, model.inverse_mass, 0.0))

    def watch(self, x: Floats, tick: float) -> None:
        """Note, after a tick [s], which regions have gone beyond the slack."""
        far = _beyond(x, self.settled, self.regions.slack) & self.vertices
        self.settled[:, far] = x[:, far]
        self._note(far)
        self.clock += tick

    def _note(self, far: Bools) -> None:
        self.moved[self.regions.of[far]] = self.clock


def _placed(rest: Floats, pose: Pose | None) -> Floats:
    if pose is None:
        return rest
    at: Floats = pose[0] @ rest + pose[1][:, None]
    return at


def _beyond(x: Floats, start: Floats, slack: float) -> Bools:
    way = x - start
    return np.asarray((way * way).sum(axis=0) > slack * slack)
