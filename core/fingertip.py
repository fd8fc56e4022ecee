"""A fingertip of a session: where it is to be, and its way there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .solver.motion import FingertipMotion, Vector


@dataclass(frozen=True, slots=True)
class Finger:
    """A fingertip: the centre (3,) and radius of a sphere [m]."""

    position: Vector
    radius: float


@dataclass(slots=True)
class FingerOnItsWay:
    """A fingertip that is down, during a step: it moves linearly from the step's begin to its end.

    target: where it is to be at the end.
    origin: where it was at the begin [m].
    here: where it is [m].
    fresh: no tick has moved it since it was put down.
    """

    target: Finger
    origin: Vector
    here: Vector
    fresh: bool = True

    def motion(self, first: float, last: float) -> FingertipMotion:
        """Return the motion of some ticks, as shares of the way that are over at the end of the first and the last."""
        target, origin = self.target, self.origin
        at, until = between(origin, target.position, first), between(origin, target.position, last)
        return FingertipMotion(self.here, at, until, target.radius, self.fresh)


def put_down(finger: Finger) -> FingerOnItsWay:
    """Return a fingertip that has just come down where it is to be."""
    place = vector(finger.position)
    return FingerOnItsWay(finger, place, place)


def vector(a: Sequence[float]) -> Vector:
    """Return three numbers as Python's own."""
    x, y, z = a
    return float(x), float(y), float(z)


def between(a: Vector, b: Vector, share: float) -> Vector:
    """Return the point at a share of the way from a to b."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])
