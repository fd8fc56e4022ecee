"""A fingertip of a session: where it is to be, or what pushes it, and its way there."""

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
    """A fingertip: a sphere that goes to a given place, or is pushed by a force.

    position: of its centre (3,) [m]; of one that is pushed, where it touches before it goes in.
    radius: [m].
    force: that pushes it from there [N], None where its place is prescribed.
    inward: unit vector (3,) of that force.
    via: where it is at even times of the next step before its end, (3,) each [m]; in between it goes straight.
    fresh_contact: it comes down there from elsewhere, not over the surface.
    """

    position: Vector
    radius: float
    force: float | None = None
    inward: Vector = (0.0, 0.0, -1.0)
    via: tuple[Vector, ...] = ()
    fresh_contact: bool = False


@dataclass(slots=True)
class FingerOnItsWay:
    """A fingertip that is down, during a step: it moves linearly from the step's begin to its end.

    target: where it is to be at the end.
    origin: where it was at the begin [m]; of one that is pushed, where it would be without the force.
    here: where it is [m].
    fresh: no tick has moved it since it was put down.
    impulse: that the body has given it in the step under way [N s].
    """

    target: Finger
    origin: Vector
    here: Vector
    fresh: bool = True
    impulse: Vector = ZERO

    def motion(self, first: float, last: float, factors: Factors = None) -> FingertipMotion:
        """Return the motion of some ticks, as shares of the way that are over at the end of the first and the last.

        Args:
            factors: of the force of its tip.
        """
        soon, to = self.place(first), self.target
        late = soon if last == first else self.place(last)
        return FingertipMotion(self.here, soon, late, to.radius, self.fresh, to.force or 0.0, to.inward, factors)

    def take(self, touch: Touch, seconds: float) -> float:
        """Go where it is after some ticks; return what work it did on the body in those seconds [J]."""
        # force and way of straight, even motion: the work is exact
        work = -dot(along(touch.centre, self.here, -1.0), touch.impulse) / seconds
        self.here, self.fresh = touch.centre, False
        (a, b, c), (x, y, z) = self.impulse, touch.impulse
        self.impulse = a + x, b + y, c + z
        return work

    def finger(self) -> Finger:
        """Return where it is to be; one that is pushed, where it has been pushed."""
        return self.target if self.target.force is None else self.target._replace(position=self.here)

    def scale(self, scale: float) -> None:
        """Multiply all lengths, as if it had just been put down."""
        self.origin, self.here, self.fresh = scaled(self.origin, scale), scaled(self.here, scale), True

    def place(self, share: float) -> Vector:
        """Return where it is at a share of the step; of one that is pushed, where it would be without the force."""
        places = self.origin, *self.target.via, self.target.position
        leg = min(int(share * (len(places) - 1)), len(places) - 2)
        return between(places[leg], places[leg + 1], share * (len(places) - 1) - leg)


def is_possible(finger: Finger) -> bool:
    """Tell whether a fingertip has a place and a force that are numbers, and a size."""
    position, radius, force, (a, b, c), via, _ = finger
    if len(position) != 3 or not radius > 0:
        return False
    x, y, z = map(sum, zip(position, *via, strict=True))
    return isfinite(x + y + z + a + b + c + radius + (force or 0.0))


def sent(tip: FingerOnItsWay | None, finger: Finger | None) -> FingerOnItsWay | None:
    """Return a fingertip on its way to another place, one that has just come down there, or None for a lifted one."""
    if finger is None:
        return None
    if tip is None or finger.fresh_contact:
        place = vector(finger.position)
        tip = FingerOnItsWay(finger, place, place)
    tip.target = finger
    return tip


def vector(a: Sequence[float]) -> Vector:
    """Return three numbers as Python's own."""
    x, y, z = a
    return float(x), float(y), float(z)


def between(a: Vector, b: Vector, share: float) -> Vector:
    """Return the point at a share of the way from a to b."""
    if share == 1.0:
        return b
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])
