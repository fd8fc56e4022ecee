"""Constants that are changed come in gently: what the forces were more before is a load, and fades.

With forces F before and F' after, the load begins as F - F' on each vertex, so that nothing jumps, not even an
acceleration. It is the last of three lags in a row, so it starts to fade without a jolt; and as that is linear, changes
that follow each other, while a number is dragged, add up. In the step that shows a change first it fades no farther
than in a sixtieth of a second, however long that step is, and at full speed from the next one on.

How far a skin gives way fades as a number, and so does the pressure of a fill: as a load, which does not turn with the
surface, it would buckle a soft skin.

Where a body hardens under a fingertip that a force pushes, friction would keep its dent as wide as it was. So friction
fades with the load, and the force goes back most of the way and returns after that, as if the body were pressed anew.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..base import Floats
from ..body.forces import Shape, law_forces, shape_of
from ..body.model import Model
from ..body.shape_matching import fit_pose, pose_of

LAG = 0.04  # [s] so that after a sixtieth of a second a hundredth has faded
FIRST_S = 1 / 60  # [s] by which a change fades at most in the step that shows it first
OVER = 12  # lags after which nothing is left of the load
BACK = 8  # lags in which the force returns after that
NOTICED = 1e-6  # of its force: by so much more a dent must resist to have hardened
GIVES_WAY = 0.7  # of its force: what a fingertip gives way by where a body becomes twice as hard, or more


class Glide:
    """How a body of n vertices comes from one rest to another.

    pressure: that its fill has more than the constants say [Pa].
    compliance: that its skin has more than they say (n,) [m/N].
    seconds: since its constants were changed last.
    hardens: its dent meets more resistance than before, and
    since: so long a fingertip gives way to that [s].
    """

    def __init__(self, n: int) -> None:
        self._lags: tuple[Floats, ...] = (np.zeros(4 * n + 1),) * 3  # of the load, the compliance, and the pressure
        self._fresh: tuple[Floats, ...] = self._lags  # of a change that the step under way shows first
        self._rate = 1.0  # at which those fade
        self.seconds, self.since, self.hardens = 0.0, 0.0, False
        self._given_before = self._to_give = 0.0  # when it began to give way, and what that leads to

    def add(self, before: Model, after: Model, x: Floats) -> None:
        """Change the constants of a body that is at x (3, n) [m]."""
        pose = _pose(after, x)
        same = before.rigged == after.rigged and np.array_equal(before.pinned, after.pinned)
        pose_before = pose if same else _pose(before, x)
        shape = shape_of(before, x)
        force, ends = _forces(pumped(before, self.pressure), x, pose_before, shape), _forces(after, x, pose, shape)
        more = self._keep_pressure(before, after)
        load = force - (_forces(pumped(after, self.pressure + more), x, pose, shape) if self.pressure + more else ends)
        rotation, translation = pose_of(after.matching, x, pose)
        dent = x - rotation @ after.matching.rest - translation[:, None]
        self._fresh = (np.concatenate([load.ravel(), before.compliance - after.compliance, [more]]),) * 3
        hardening = -float(((force - ends) * dent).sum()) / min(float((force * dent).sum()), -1e-30)
        self.seconds, to_give = 0.0, min(self._given + hardening, 1.0)
        # what gives way to an earlier change, or returns from it, goes on with that, unless this one asks for more
        if hardening > NOTICED and not (self._gives_way and to_give <= self._to_give):
            self._given_before, self._to_give = self._given, to_give
            self.since, self.hardens = 0.0, True

    def begin(self, seconds: float) -> None:
        """Begin a step of so many seconds."""
        self._rate = min(FIRST_S / max(seconds, FIRST_S), 1.0)
        if self.seconds > 0:  # there was a step since the last change
            self._settle()
            self._rate = 1.0

    def fade(self, seconds: float) -> Floats | None:
        """Let some time of a step pass and return the load (3, n) [N], None where it is over."""
        self.seconds, self.since = self.seconds + self._rate * seconds, self.since + self._rate * seconds
        if self.seconds > OVER * LAG and self.since > (OVER + self.hardens * BACK) * LAG:
            return None
        self._lags = _faded(self._lags, seconds)
        self._fresh = _faded(self._fresh, self._rate * seconds)
        return self._left[:-1].reshape(4, -1)[:3]

    @property
    def pressure(self) -> float:
        """Return how much more pressure [Pa] the fill has than the constants say."""
        return float(self._lags[0][-1] + self._fresh[0][-1])

    @property
    def compliance(self) -> Floats:
        """Return how much further (n,) [m/N] the skin gives way than the constants say."""
        return self._left[:-1].reshape(4, -1)[3]

    @property
    def _left(self) -> Floats:
        return self._lags[0] + self._fresh[0]

    def _keep_pressure(self, before: Model, after: Model) -> float:
        """Return how much more pressure [Pa] the fill had before; a fill that is taken out has none to keep."""
        self._settle()
        if after.pressure.fill == "none":
            for lag in self._lags:
                lag[-1] = 0.0
            return 0.0
        return _rest_pressure(before) - after.pressure.rest_pressure

    def _settle(self) -> None:
        self._lags = tuple(lag + fresh for lag, fresh in zip(self._lags, self._fresh, strict=True))
        self._fresh = (np.zeros_like(self._lags[0]),) * 3

    @property
    def friction(self) -> float:
        """Return the share of its friction that acts."""
        return 1 - self._given if self._gives_way else 1.0

    @property
    def push(self) -> float:
        """Return the share of its force by which a fingertip is pushed."""
        return 1 - GIVES_WAY * self._given

    @property
    def _gives_way(self) -> bool:
        return self.hardens and self.since < OVER * LAG

    @property
    def _given(self) -> float:
        """Return how far a fingertip has given way, from 0 to 1."""
        given, past = self._given_before, self.since / LAG
        if self.hardens:
            given = self._to_give - (self._to_give - given) * math.exp(-past) * (1 + past + past**2 / 2)
            past = max(past - OVER, 0.0)
        return given * (0.5 + 0.5 * math.cos(math.pi * min(past / BACK, 1.0)))


def _faded(lags: tuple[Floats, ...], seconds: float) -> tuple[Floats, ...]:
    (first, second, third), past = lags, seconds / LAG
    after = first + past * second + past**2 / 2 * third, second + past * third, third
    return tuple(math.exp(-past) * lag for lag in after)


def _rest_pressure(model: Model) -> float:
    return 0.0 if model.pressure.fill == "none" else model.pressure.rest_pressure


def pumped(model: Model, more: float) -> Model:
    """Return a model with more pressure [Pa] at rest."""
    inside = model.pressure
    return replace(model, pressure=replace(inside, rest_pressure=inside.rest_pressure + more)) if more else model


def may_glide(before: Model, after: Model) -> bool:
    """Tell whether two models hold a body in the same way."""
    return before.free == after.free


def _pose(model: Model, x: Floats) -> tuple[Floats, Floats] | None:
    """Return the pose of the shape at rest with its pins, None where it is free."""
    if model.free or model.rigged:
        return None if model.free else (np.eye(3), np.zeros(3))
    pins = np.flatnonzero(model.pinned & ~model.mesh.loose)
    return fit_pose(model.mesh.rest_positions.T[:, pins], x[:, pins], np.ones(len(pins)))


def _forces(model: Model, x: Floats, pose: tuple[Floats, Floats] | None, shape: Shape) -> Floats:
    """Return the forces (3, n) [N] on a body at rest; of one that is free without its weight, with which it falls."""
    found, _, _ = law_forces(model, x, pose, shape=shape)
    return found if model.free else found + model.mass * model.gravity[:, None]
