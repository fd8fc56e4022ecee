"""A fingertip of a session: its prescribed position or the force that pushes it, and its path during a step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import NamedTuple

from ..base import Floats
from ..native.motion import FingertipMotion, Touch
from ..vectors import ZERO, Vector, along, dot, scaled

Factors = tuple[Floats, float] | None


class Finger(NamedTuple):
    """A fingertip: a sphere that moves to a prescribed position, or is pushed by a force.

    position: of its centre (3,) [m]; if a force pushes it, where it touches before it goes in.
    radius: [m].
    force: force that pushes it from there [N], None if its position is prescribed.
    inward: unit vector (3,) of that force.
    via: positions (3,) [m] at equal intervals within the next step; the path between them is straight.
    fresh_contact: it is put down there from elsewhere, rather than moved over the surface.
    """

    position: Vector
    radius: float
    force: float | None = None
    inward: Vector = (0.0, 0.0, -1.0)
    via: tuple[Vector, ...] = ()
    fresh_contact: bool = False


@dataclass(slots=True)
class FingerOnItsWay:
    """A fingertip that is down, during a step: it moves from its position at the start to that at the end.

    target: the fingertip as it is to be at the end.
    origin: position at the start [m]; if a force pushes it, the one without that force.
    here: current position [m].
    fresh: no tick has moved it since it was put down.
    impulse: impulse that the body has given it in the current step [N s].
    """

    target: Finger
    origin: Vector
    here: Vector
    fresh: bool = True
    impulse: Vector = ZERO

    def motion(self, first: float, last: float, factors: Factors = None) -> FingertipMotion:
        """Return the motion from the shares of the way that are covered at the end of its first and its last tick.

        Args:
            factors: on the force of its tip.
        """
        soon, to = self.place(first), self.target
        late = soon if last == first else self.place(last)
        return FingertipMotion(self.here, soon, late, to.radius, self.fresh, to.force or 0.0, to.inward, factors)

    def take(self, touch: Touch, seconds: float) -> float:
        """Take its position after some ticks; return the work that it did on the body in those seconds [J]."""
        # mean force times displacement: exact, because the motion is straight and even
        work = -dot(along(touch.centre, self.here, -1.0), touch.impulse) / seconds
        self.here, self.fresh = touch.centre, False
        (a, b, c), (x, y, z) = self.impulse, touch.impulse
        self.impulse = a + x, b + y, c + z
        return work

    def finger(self) -> Finger:
        """Return it as it is to be; if a force pushes it, at its current position."""
        return self.target if self.target.force is None else self.target._replace(position=self.here)

    def scale(self, scale: float) -> None:
        """Multiply all lengths, and treat it as just put down."""
        self.origin, self.here, self.fresh = scaled(self.origin, scale), scaled(self.here, scale), True

    def place(self, share: float) -> Vector:
        """Return its position at a share of the step; if a force pushes it, the one without that force."""
        places = self.origin, *self.target.via, self.target.position
        leg = min(int(share * (len(places) - 1)), len(places) - 2)
        return between(places[leg], places[leg + 1], share * (len(places) - 1) - leg)


def is_possible(finger: Finger) -> bool:
    """Return whether a fingertip has a finite position and force, and a positive radius."""
    position, radius, force, (a, b, c), via, _ = finger
    if len(position) != 3 or not radius > 0:
        return False
    x, y, z = map(sum, zip(position, *via, strict=True))
    return isfinite(x + y + z + a + b + c + radius + (force or 0.0))


def sent(tip: FingerOnItsWay | None, finger: Finger | None) -> FingerOnItsWay | None:
    """Return a fingertip on its way to a new target, a new one that was just put down there, or None if lifted."""
    if finger is None:
        return None
    if tip is None or finger.fresh_contact:
        place = vector(finger.position)
        tip = FingerOnItsWay(finger, place, place)
    tip.target = finger
    return tip


def vector(a: Sequence[float]) -> Vector:
    """Return three numbers as Python floats."""
    x, y, z = a
    return float(x), float(y), float(z)


def between(a: Vector, b: Vector, share: float) -> Vector:
    """Return the point at a share of the way from a to b."""
    if share == 1.0:
        return b
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])
