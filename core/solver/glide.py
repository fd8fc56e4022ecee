"""Constants that are changed come in gently: what the forces were more before is a load, and fades.

With forces F before and F' after, the load begins as F - F' on each vertex, so that nothing jumps, not even an
acceleration. It is the last of three lags in a row, so it starts to fade without a jolt; and as that is linear, changes
that follow each other, while a number is dragged, add up.

Where a body hardens under a fingertip that a force pushes, friction would keep its dent as wide as it was. So friction
fades with the load, and the force goes back a little and returns in the end, as if the body were pressed anew.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import Floats
from ..body.model import Model, State, forces
from ..body.shape_matching import fit_pose, pose_of

LAG = 0.04  # [s] so that after a sixtieth of a second a hundredth has faded
OVER = 12  # lags after which nothing is left
GIVES_WAY = 0.4  # of its force: what a fingertip gives way by


class Glide:
    """How a body of n vertices comes from one rest to another.

    seconds: since its constants were changed last.
    hardens: its dent meets more resistance than before.
    """

    def __init__(self, n: int) -> None:
        self._lags: tuple[Floats, ...] = (np.zeros((3, n)),) * 3
        self.seconds, self.hardens = 0.0, False

    def add(self, before: Model, after: Model, x: Floats) -> None:
        """Change the constants of a body that is at x (3, n) [m]."""
        load = _forces(before, x) - _forces(after, x)
        rotation, translation = pose_of(after.matching, x, _pose(after, x))
        dent = x - rotation @ after.matching.rest - translation[:, None]
        self._lags = tuple(lag + load for lag in self._lags)
        self.seconds, self.hardens = 0.0, float((load * dent).sum()) > 0

    def fade(self, seconds: float) -> Floats | None:
        """Let some time pass and return the load (3, n) [N], None where it is over."""
        self.seconds += seconds
        if self.seconds > OVER * LAG:
            return None
        (first, second, third), past = self._lags, seconds / LAG
        lags = first + past * second + past**2 / 2 * third, second + past * third, third
        self._lags = tuple(math.exp(-past) * lag for lag in lags)
        return self._lags[0]

    @property
    def friction(self) -> float:
        """Return the share of its friction that acts."""
        past = self.seconds / LAG
        return math.exp(-past) * (1 + past + past**2 / 2) if self.hardens else 1.0

    @property
    def push(self) -> float:
        """Return the share of its force by which a fingertip is pushed."""
        return 1 - GIVES_WAY * (1 - self.friction)


def may_glide(before: Model, after: Model) -> bool:
    """Tell whether two models hold a body in the same way, by the laws that know a load."""
    return before.free == after.free and {before.law_set, after.law_set} == {"consistent"}


def _pose(model: Model, x: Floats) -> tuple[Floats, Floats] | None:
    """Return the pose of the shape at rest with its pins, None where it is free."""
    if model.free or model.rigged:
        return None if model.free else (np.eye(3), np.zeros(3))
    pins = np.flatnonzero(model.held & ~model.mesh.loose)
    return fit_pose(model.mesh.rest_positions.T[:, pins], x[:, pins], np.ones(len(pins)))


def _forces(model: Model, x: Floats) -> Floats:
    """Return the forces (3, n) [N] on a body at rest; of one that is free without its weight, with which it falls."""
    found = forces(model, State(positions=x, velocities=np.zeros_like(x), pose=_pose(model, x)))
    return found - model.mass * model.gravity[:, None] if model.free else found
