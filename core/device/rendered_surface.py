"""The force on a fingertip, evaluated 1000 times a second on a surface that Blender updates 60 times a second.

Blender sends the plane of the surface under each fingertip and the constants of the law there. Depth, force and
friction are evaluated here, at the present position of the fingertip, by the law that presses the body: a force held
for a frame would be stable only below 217 N/m, and a single slope would be wrong beyond the knee. A slope steeper than
the device can render is limited to what it can.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from ..material import law_force
from ..vectors import ZERO, Vector, along, capped, dot, is_finite, scaled
from .limits import FARTHEST, LEVEL, LOST_TIME, PASSIVE_SHARE, SIDEWAYS, SLOWEST_FRAME, STATE_GAP, STIFFEST

STEPS = 16  # of an integral over depth: at most 1 % too large if K2 is 12 K1, as of vinyl, and 9 % if it is 100 K1
FINE = 1e-4  # [m] between two depths at which the slope of a law is evaluated: 0.1 N at 1 N/mm


class Law(NamedTuple):
    """The law on one fingertip.

    K1, K2: slopes up to the knee and beyond [N/m].
    x0: depth of the knee [m].
    power: exponent of the depth in the initial force, 1 for two straight pieces.
    factors: on the force of a tip other than the measuring one, at depths that grow with the square of the index; ()
        for none.
    deepest: the last of these depths [m].
    """

    K1: float
    K2: float
    x0: float
    power: float
    factors: tuple[float, ...] = ()
    deepest: float = 0.0

    def factor(self, depth: float) -> tuple[float, float]:
        """Return the tip's factor at a depth [m], constant beyond the deepest, and its slope times that depth."""
        if not self.factors:
            return 1.0, 0.0
        last = len(self.factors) - 1
        at = math.sqrt(min(max(depth / self.deepest, 0.0), 1.0)) * last
        k = min(int(at), last - 1)
        step = self.factors[k + 1] - self.factors[k]
        return self.factors[k] + (at - k) * step, step * at / 2 if at < last else 0.0

    def force(self, depth: float, cap: float) -> float:
        """Return the force [N] at a depth [m], its slope limited to a cap [N/m]: a function of the depth alone."""
        factor, growth = self.factor(depth)
        if not factor > 0:
            return 0.0
        steepest = cap / (factor + max(growth, 0.0))
        return factor * law_force(
            depth, min(self.K1, steepest / self.power**2), min(self.K2, steepest), self.x0, self.power
        )

    def energy(self, depth: float, cap: float) -> float:
        """Return the energy [J] that a press to a depth [m] stores, by the trapezoid rule: little more than it is."""
        step = max(depth, 0.0) / STEPS
        return step * (sum(self.force(k * step, cap) for k in range(1, STEPS)) + self.force(depth, cap) / 2)

    def steepest(self, force: float) -> float:
        """Return the stiffness [N/m] that a device must be able to render for an unchanged law up to a force [N]."""
        depth = steepest = 0.0
        while self.force(depth, math.inf) < force and depth < FARTHEST:
            factor, growth = self.factor(depth)
            slope = self.K2 if depth > self.x0 else self.power**2 * self.K1
            steepest = max(steepest, slope * (factor + max(growth, 0.0)))
            depth += FINE
        return steepest


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """The surface under one fingertip, in the space of the device.

    place: position of the fingertip's centre at which contact begins [m].
    normal: unit vector out of the body.
    anchor: position [m] to which friction holds the fingertip's centre, None if it does not touch.
    law: the measured law there.
    friction: Coulomb coefficient.
    stamp: time at which the simulation evaluated the surface [s].
    """

    place: Vector
    normal: Vector
    anchor: Vector | None
    law: Law
    friction: float
    stamp: float

    def depth(self, x: Vector) -> float:
        """Return the depth [m] of a fingertip at x [m], negative if it does not touch."""
        return dot(along(self.place, x, -1.0), self.normal)


def is_sane(surface: Surface) -> bool:
    """Return whether the numbers of a surface are finite and plausible: a unit normal, and no negative constant."""
    places, law = (surface.place, surface.anchor or surface.place), surface.law
    return (
        all(map(is_finite, (*places, surface.normal)))
        and max(max(map(abs, place)) for place in places) <= FARTHEST
        and all(0 <= number <= STIFFEST for number in (*law[:4], *law.factors, surface.friction))
        and (not law.factors or (len(law.factors) > 1 and 0 < law.deepest <= FARTHEST))
        and law.power >= 1
        and abs(dot(surface.normal, surface.normal) - 1) < LEVEL
        and math.isfinite(surface.stamp)
    )  # fmt: skip


def stiffness_cap(viscous: float, period: float, delay: float) -> float:
    """Return the largest stiffness [N/m] to render: 0.8 b / (T/2 + t_d).

    Args:
        viscous: friction b of the device [N s/m].
        period: T of its tick [s].
        delay: t_d from sensor to motor [s].

    Source: Colgate and Brown's condition for a passive wall, with a delay; tests.haptics.walls finds the same limit.
    """
    return PASSIVE_SHARE * viscous / (period / 2 + delay)


def left_at(age: float) -> float:
    """Return the share of the force that is left at an age [s] of its surface: if the simulation hangs, it fades."""
    if age < -STATE_GAP:
        return 0.0  # from the future: a stamp of another clock
    return min(max(2 - age / LOST_TIME, 0.0), 1.0)


@dataclass(slots=True)
class Contact:
    """The contact of one fingertip with the newest surface; a new surface causes no jump of the force.

    Friction is a spring to an anchor, which the fingertip drags along if it pulls harder than friction holds.

    surface: the newest, None if there is none.
    cap: largest stiffness that is rendered [N/m].
    anchor: position to which friction holds the fingertip's centre [m], None if it does not touch.
    stick: stiffness of that spring [N/m], from the depth at which the surface was taken or touched.
    jump: force on the previous surface minus that on this one [N]; it decays over one frame.
    arrived: when the surface arrived [s].
    frame: period of the simulation [s].
    """

    surface: Surface | None = None
    cap: float = math.inf
    anchor: Vector | None = None
    stick: float = 0.0
    jump: Vector = ZERO
    arrived: float = -math.inf
    frame: float = SLOWEST_FRAME

    def take(self, surface: Surface | None, x: Vector, now: float, cap: float) -> None:
        """Take a new surface, or None, while the fingertip is at x [m]."""
        before = self.force(x, now)
        self.frame = min(now - self.arrived, SLOWEST_FRAME)
        self.surface, self.cap, self.arrived, self.jump, self.stick = surface, cap, now, ZERO, 0.0
        if surface is None or surface.anchor:
            self.anchor = surface.anchor if surface else None
        self.jump = along(before, self.force(x, now), -1.0)

    def force(self, x: Vector, now: float) -> Vector:
        """Return the force [N] on the fingertip at x [m]."""
        age = now - self.arrived
        jump = scaled(self.jump, 1 - age / self.frame) if age < self.frame else ZERO
        if self.surface is None:
            return jump
        whole = along(jump, self._press(self.surface, x), 1.0)
        # the remainder of the previous force must not pull inwards
        return along(whole, self.surface.normal, -min(dot(whole, self.surface.normal), 0.0))

    def energy(self, x: Vector) -> float:
        """Return the energy [J] stored under the fingertip at x [m]: what it may give back."""
        return self.surface.law.energy(self.surface.depth(x), self.cap) if self.surface else 0.0

    def _press(self, surface: Surface, x: Vector) -> Vector:
        """Evaluate law and friction at x [m]; drag the anchor along."""
        depth, normal = surface.depth(x), surface.normal
        push = surface.law.force(depth, self.cap)
        if not push > 0:
            self.anchor, self.stick = None, 0.0
            return ZERO
        self.anchor = self.anchor or x
        self.stick = self.stick or SIDEWAYS * push / depth
        way = along(self.anchor, x, -1.0)
        way = capped(along(way, normal, -dot(way, normal)), surface.friction * push / self.stick)
        self.anchor = along(x, way, 1.0)
        return along(scaled(normal, push), way, self.stick)
