"""The force on a fingertip, 1000 times a second, between two frames of the simulation: a local linear contact.

    F(x) = F0 - [k_n n n^T + k_t (I - n n^T)] (x - x0)

A force held from frame to frame would be stable only on soft objects; a contact that is evaluated where the fingertip
is now is stable up to the device's own limit (`stiffness_cap`). It can push and slide, never pull.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..vectors import ZERO, Vector, along, capped, dot, is_finite, scaled

FADE_BEGINS, FADE_ENDS = 0.100, 0.200  # [s] age of a contact: that of a frozen simulation fades out
LONGEST_SLEW = 0.050  # [s] a change is spread over one period of the simulation, but over no more than this
SHORTEST_SLEW = 0.001  # [s] one tick
MOST_AHEAD = 0.005  # [s] a stamp farther in the future is not of this clock
MOST_FORCE, MOST_STIFFNESS, FARTHEST = 1e3, 1e6, 10.0  # [N], [N/m], [m] more is an error
UNIT = 1e-3  # how far from 1 the length of a normal may be
PASSIVE_SHARE = 0.8  # of the passive stiffness: the rest covers errors in the estimates of b and of the delay


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """The contact of one fingertip, in the space of the device.

    force: on the fingertip where the simulation had it [N].
    at: where that was [m].
    normal: unit vector out of the body.
    k_n, k_t: stiffness along the normal and across it [N/m].
    gap: distance left to the surface where it does not touch [m].
    friction: Coulomb coefficient.
    stamp: when the simulation was there [s].
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
        viscous: friction b of the device [N s/m].
        period: of its tick T [s].
        delay: from sensor to motor t_d [s].

    Source: Colgate and Brown's condition for a passive wall, with a delay; tests.haptics.walls finds the same limit.
    """
    return PASSIVE_SHARE * viscous / (period / 2 + delay)


def is_sane(contact: Contact) -> bool:
    """Tell whether the numbers of a contact are finite and plausible: a unit normal, and no negative ones."""
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
    sideways = along(contact.force, n, -dot(contact.force, n))
    slid = along(way, n, -height)
    grip = capped(along(sideways, slid, -min(contact.k_t, cap)), contact.friction * push)
    return along(grip, n, push)


def fade(age: float) -> float:
    """Return the share of the force that is left at an age [s]."""
    if age < -MOST_AHEAD:
        return 0.0
    return min(max((FADE_ENDS - age) / (FADE_ENDS - FADE_BEGINS), 0.0), 1.0)


@dataclass(slots=True)
class ContactBlend:
    """The newest contact of one fingertip, blended in without a jump of the force.

    contact: the newest, None where there is none.
    jump: the force before it less its own [N]; it decays over one period.
    arrived: when it came [s].
    period: of the simulation [s].
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
