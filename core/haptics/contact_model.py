"""What a fingertip feels, 1000 times a second, between two frames of the simulation: a local linear contact.

    F(x) = F0 - [k_n n n^T + k_t (I - n n^T)] (x - x0)

Forces held from frame to frame would be stable only on soft objects; a contact evaluated where the fingertip is
now is stable up to the device's own limit (`stiffness_cap`). It can push and slide, never pull.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .vectors import ZERO, Vector, along, capped, dot, is_finite, scaled

FADE_BEGINS, FADE_ENDS = 0.100, 0.200  # [s] age of the simulation's last word: a frozen one lets go
LONGEST_SLEW = 0.050  # [s] a change is spread over one period of the simulation, a slow one over no more than this
SHORTEST_SLEW = 0.001  # [s] one tick
MOST_AHEAD = 0.005  # [s] a stamp farther in the future is no time of this clock
MOST_FORCE, MOST_STIFFNESS, FARTHEST = 1e3, 1e6, 10.0  # [N], [N/m], [m] more is a mistake
UNIT = 1e-3  # how far from 1 the length of a normal may be
PASSIVE_SHARE = 0.8  # of the stiffness that is still passive: what is left bears the estimate of b and of the delay


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Hold the contact of one fingertip, in the space of the device.

    force: on the fingertip [N] at: [m].  normal: unit, out of the body.  k_n, k_t: [N/m].  gap: [m] left to the
    surface where it does not touch.  friction: Coulomb coefficient.  stamp: when the simulation was there [s].
    """

    force: Vector
    at: Vector
    normal: Vector
    k_n: float
    k_t: float
    gap: float
    friction: float
    stamp: float


def stiffness_cap(viscous: float, period: float, delay: float) -> float:
    """Return the largest stiffness [N/m] to render: 0.8 b / (T/2 + t_d).

    Args:
        viscous: friction b of the device [N s/m].  period: of its tick T [s].  delay: from sensor to motor t_d [s].

    Source: Colgate and Brown's condition for a passive wall, with a delay; tests.haptics.walls finds the same limit.
    """
    return PASSIVE_SHARE * viscous / (period / 2 + delay)


def is_sane(contact: Contact) -> bool:
    """Tell whether a contact is made of numbers of this world, its normal a unit vector and nothing negative."""
    numbers = (contact.k_n, contact.k_t, contact.gap, contact.friction)
    return (
        all(map(is_finite, (contact.force, contact.at, contact.normal)))
        and all(0 <= number <= MOST_STIFFNESS for number in numbers)
        and max(map(abs, contact.force)) <= MOST_FORCE
        and max(map(abs, contact.at)) <= FARTHEST
        and abs(dot(contact.normal, contact.normal) - 1) < UNIT
        and math.isfinite(contact.stamp)
    )


def force_at(contact: Contact, x: Vector, cap: float) -> Vector:
    """Return the force [N] on a fingertip at x [m], no stiffness above a cap [N/m]."""
    n = contact.normal
    way = along(x, contact.at, -1.0)
    height = dot(way, n)
    push = dot(contact.force, n) - min(contact.k_n, cap) * (height + contact.gap)
    if push <= 0:
        return ZERO
    held = along(contact.force, n, -dot(contact.force, n))
    slid = along(way, n, -height)
    grip = capped(along(held, slid, -min(contact.k_t, cap)), contact.friction * push)
    return along(grip, n, push)


def fade(age: float) -> float:
    """Return the share of the force that is left at an age [s]."""
    if age < -MOST_AHEAD:
        return 0.0
    return min(max((FADE_ENDS - age) / (FADE_ENDS - FADE_BEGINS), 0.0), 1.0)


@dataclass(slots=True)
class Feel:
    """Follow the contacts of one fingertip as they come, without a jump.

    jump: what the newest contact's force lacked of the one before it [N]; it dies out over one period.
    """

    contact: Contact | None = None
    jump: Vector = ZERO
    arrived: float = -math.inf
    period: float = SHORTEST_SLEW

    def take(self, contact: Contact | None, x: Vector, now: float, cap: float) -> None:
        """Take a new contact, None for none, while the fingertip is at x [m]."""
        before = self.force(x, now, cap)
        self.period = min(max(now - self.arrived, SHORTEST_SLEW), LONGEST_SLEW)
        self.contact, self.arrived, self.jump = contact, now, ZERO
        self.jump = along(before, self.force(x, now, cap), -1.0)

    def force(self, x: Vector, now: float, cap: float) -> Vector:
        """Return the force [N] on the fingertip at x [m]."""
        left = min(max(1 - (now - self.arrived) / self.period, 0.0), 1.0)
        if self.contact is None:
            return scaled(self.jump, left)
        share = fade(now - self.contact.stamp)
        whole = along(scaled(force_at(self.contact, x, cap), share), self.jump, left)
        # what is left of the force before must not pull
        return along(whole, self.contact.normal, -min(dot(whole, self.contact.normal), 0.0))
