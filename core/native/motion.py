"""The input and the result of one call for a body, the same for the native core and its numpy reference."""

from __future__ import annotations

from typing import NamedTuple

from ..base import Floats
from ..vectors import Vector


class FingertipMotion(NamedTuple):
    """The path of one fingertip: straight from start to first in the first tick, then evenly to last.

    start, first, last: centres (3,) [m].
    radius: of the fingertip [m].
    fresh: it was lifted before, or down elsewhere.
    force: force that pushes it on from there, to the depth at which the law balances it [N]; 0 for none.
    inward: unit vector (3,) of that force.
    factors: on the force of a tip other than the measuring one, see `other_tip.factors`.
    """

    start: Vector
    first: Vector
    last: Vector
    radius: float
    fresh: bool = False
    force: float = 0.0
    inward: Vector = (0.0, 0.0, -1.0)
    factors: tuple[Floats, float] | None = None


class PinMotion(NamedTuple):
    """The path of pinned vertices: evenly from start to end, (3, pinned) [m] in the order of the vertices.

    first, last: share of that path covered at the end of the first tick and of the last.
    """

    start: Floats
    end: Floats
    first: float
    last: float


class Motion(NamedTuple):
    """The motion imposed on a body for a number of ticks.

    ticks: their number.
    substeps: number of equal substeps in a tick.
    tick: duration [s].
    fingertips: up to three, None for a lifted one.
    pins: path of the pinned vertices, None if they rest.
    """

    ticks: int
    substeps: int
    tick: float
    fingertips: tuple[FingertipMotion | None, ...] = ()
    pins: PinMotion | None = None


class Touch(NamedTuple):
    """The contact of a fingertip with a body at the end of a call.

    impulse: impulse (3,) that the body gave it during the call [N s].
    centre: its position (3,) [m].
    depth: below the surface at rest, from where it met the skin [m]; negative if it does not touch.
    outward: outward unit normal (3,) of the surface there.
    force: force (3,) on it [N]: the measured law along `outward`, and friction.
    slope: of the law there [N/m].
    friction: Coulomb coefficient there.
    law: K1, K2 [N/m], x0 [m] and power there, including painted maps and the factor of another tip at this depth.
    triangle: index of the nearest triangle of the surface.
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
    """The result of a call.

    touches: one for each fingertip, None for a lifted one.
    volume: [m3] and
    pressure: [Pa] when the forces were last evaluated.
    ticks: number of ticks done.
    finite: False if the body blew up in the last of them.
    moved: False if the body slept throughout, at rest and in place.
    """

    touches: tuple[Touch | None, ...]
    volume: float
    pressure: float
    ticks: int
    finite: bool
    moved: bool = True
