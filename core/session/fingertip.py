"""The fingertips of a session: the prescribed position of each or the force that pushes it, and its path in a step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import NamedTuple

from ..base import DimpleError, Floats
from ..constants import MAX_FINGERTIPS
from ..material import Material
from ..native.motion import FingertipMotion, Touch
from ..other_tip import factors
from ..vectors import Vector, along, dot, scaled

Factors = tuple[Floats, float] | None
FingertipMotions = tuple[FingertipMotion | None, ...]


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
    """

    target: Finger
    origin: Vector
    here: Vector
    fresh: bool = True

    def motion(self, first: float, last: float, factors: Factors) -> FingertipMotion:
        """Return the motion from the shares of the way that are covered at the end of its first and its last tick."""
        soon, to = self.place(first), self.target
        late = soon if last == first else self.place(last)
        return FingertipMotion(self.here, soon, late, to.radius, self.fresh, to.force or 0.0, to.inward, factors)

    def take(self, touch: Touch, seconds: float) -> float:
        """Take its position after some ticks; return the work that it did on the body in those seconds [J]."""
        # mean force times displacement: exact, because the motion is straight and even
        work = -dot(along(touch.centre, self.here, -1.0), touch.impulse) / seconds
        self.here, self.fresh = touch.centre, False
        return work

    def finger(self) -> Finger:
        """Return it as it is to be; if a force pushes it, at its current position."""
        return self.target if self.target.force is None else self.target._replace(position=self.here)

    def place(self, share: float) -> Vector:
        """Return its position at a share of the step; if a force pushes it, the one without that force."""
        places = self.origin, *self.target.via, self.target.position
        leg = min(int(share * (len(places) - 1)), len(places) - 2)
        return between(places[leg], places[leg + 1], share * (len(places) - 1) - leg)


class Fingertips:
    """The fingertips of a session, during a step; a lifted one is None."""

    def __init__(self) -> None:
        self._tips: list[FingerOnItsWay | None] = []

    def __len__(self) -> int:
        """Return the number of fingertips, lifted ones included."""
        return len(self._tips)

    @property
    def _down(self) -> list[FingerOnItsWay]:
        return [tip for tip in self._tips if tip]

    @property
    def are_down(self) -> bool:
        """Return whether any is down."""
        return any(self._tips)

    @property
    def legs(self) -> int:
        """Return the largest number of straight parts of a path in the current step."""
        return max((len(tip.target.via) + 1 for tip in self._down), default=1)

    @property
    def placed(self) -> tuple[Finger | None, ...]:
        """Return them at their current positions, those that a force pushes included."""
        return tuple([tip.finger() if tip else None for tip in self._tips])

    @property
    def targets(self) -> tuple[Finger | None, ...]:
        """Return them as they are to be at the end of the step."""
        return tuple([tip.target if tip else None for tip in self._tips])

    def send(self, fingers: Sequence[Finger | None]) -> None:
        """Set the fingertips for the end of the next step.

        Raises:
            DimpleError: too many fingertips, a radius that is not positive, or a position that is not a number.
        """
        if len(fingers) > MAX_FINGERTIPS:
            raise DimpleError("There are at most {most} fingertips.", most=MAX_FINGERTIPS)
        for finger in fingers:
            if finger and not _is_possible(finger):
                raise DimpleError("A fingertip needs a location with finite coordinates and a radius greater than 0.")
        self._tips = list(map(_sent, [*self._tips, *[None] * MAX_FINGERTIPS], fingers))

    def motions(self, first: float, last: float, materials: Sequence[Material], size: float) -> FingertipMotions:
        """Return the motion of each for some ticks on a body with a size [m]; see `FingerOnItsWay.motion`."""
        return tuple([
            tip.motion(first, last, factors(materials, tip.target.radius, size)) if tip else None for tip in self._tips
        ])  # fmt: skip

    def take(self, touches: Sequence[Touch | None], seconds: float) -> float:
        """Take their positions after some ticks; return the work that they did on the body in those seconds [J]."""
        both = zip(self._tips, touches, strict=True)
        return sum(tip.take(touch, seconds) for tip, touch in both if tip and touch)

    def move(self, share: float) -> None:
        """Begin the next step after a share of this one."""
        for tip in self._down:
            tip.origin, tip.target = tip.place(share), tip.target._replace(via=(), fresh_contact=False)

    def scale(self, scale: float) -> None:
        """Multiply all lengths, and treat them as just put down."""
        for tip in self._down:
            tip.origin, tip.here, tip.fresh = scaled(tip.origin, scale), scaled(tip.here, scale), True


def _is_possible(finger: Finger) -> bool:
    """Return whether a fingertip has a finite position and force, and a positive radius."""
    position, radius, force, (a, b, c), via, _ = finger
    if len(position) != 3 or not radius > 0:
        return False
    x, y, z = map(sum, zip(position, *via, strict=True))
    return isfinite(x + y + z + a + b + c + radius + (force or 0.0))


def _sent(tip: FingerOnItsWay | None, finger: Finger | None) -> FingerOnItsWay | None:
    """Return a fingertip on its way to a new target, a new one that was just put down there, or None if lifted."""
    if finger is None:
        return None
    if tip is None or finger.fresh_contact:
        x, y, z = finger.position
        place = float(x), float(y), float(z)
        tip = FingerOnItsWay(finger, place, place)
    tip.target = finger
    return tip


def between(a: Vector, b: Vector, share: float) -> Vector:
    """Return the point at a share of the way from a to b."""
    if share == 1.0:
        return b
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])
