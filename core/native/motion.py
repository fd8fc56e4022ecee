"""What happens to a body during one call, and what comes of it: the same for the native core and its numpy twin."""

from __future__ import annotations

from typing import NamedTuple

from ..base import Floats
from ..vectors import Vector


class FingertipMotion(NamedTuple):
    """Where one fingertip goes: straight from start to first in the first tick, then evenly to last.

    start, first, last: centres (3,) [m].
    radius: of the fingertip [m].
    fresh: it was not down before, or elsewhere.
    force: that pushes it on from there, to the depth at which the law answers it [N], 0 for none.
    inward: unit vector (3,) of that.
    factors: of the force of a tip that is another than the measuring one, see `other_tip.factors`.
    """

    start: Vector
    first: Vector
    last: Vector
    radius: float
    fresh: bool = False
    force: float = 0.0
    inward: Vector = (0.0, 0.0, -1.0)
    factors: tuple[Floats, float] | None = None

    @staticmethod
    def straight(start: Vector, end: Vector, *, ticks: int, radius: float, fresh: bool = False) -> FingertipMotion:
        """Return an even motion from start to end."""
        x, y, z = ((a + (b - a) / ticks) if ticks else b for a, b in zip(start, end, strict=True))
        return FingertipMotion(start, (x, y, z), end, radius, fresh)


class PinMotion(NamedTuple):
    """Where pinned vertices are led: an even way from start to end, (3, pinned) [m] in the order of the vertices.

    first, last: the share of that way at the end of the first tick and of the last.
    """

    start: Floats
    end: Floats
    first: float
    last: float


class Motion(NamedTuple):
    """What happens to a body in some ticks.

    ticks: how many.
    substeps: equal ones in each tick.
    tick: [s].
    fingertips: up to three, None where one is lifted.
    pins: where pinned vertices are led, None where they rest.
    """

    ticks: int
    substeps: int
    tick: float
    fingertips: tuple[FingertipMotion | None, ...] = ()
    pins: PinMotion | None = None


class Touch(NamedTuple):
    """How a fingertip meets a body at the end of a call.

    impulse: that the body gave it in the call (3,) [N s].
    centre: where it is (3,) [m].
    depth: below the surface at rest, from where the skin was met [m], negative where it is clear.
    outward: unit vector (3,) of the surface there.
    force: on it (3,) [N], of the measured law, outward, and of friction.
    slope: of the law there [N/m].
    friction: Coulomb's coefficient there.
    law: K1, K2 [N/m], x0 [m] and power there, with what is painted and the factor of another tip at this depth.
    triangle: of the surface, the nearest.
    """

    impulse: Vector
    centre: Vector
    depth: float
    outward: Vector
    force: Vector
    slope: float
    friction: float
    law: tuple[float, float, float, float]
    triangle: int


class Frame(NamedTuple):
    """What a call came to.

    touches: one for each fingertip, None where it is lifted.
    volume: [m3] and
    pressure: [Pa] when the forces were last evaluated.
    ticks: done.
    finite: False where the body has blown up in the last of them.
    moved: False where it was asleep all the time, at rest, and is where it was.
    """

    touches: tuple[Touch | None, ...]
    volume: float
    pressure: float
    ticks: int
    finite: bool
    moved: bool = True
