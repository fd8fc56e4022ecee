"""Several bodies and colliders stepped together, nothing passing through anything: what goes in and comes out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints
from .motion import Frame
from .rigid import RigidShape, RigidState


class Falling(NamedTuple):
    """A rigid body that a collider is, which falls.

    shape: of what touches.
    seen: (m, 3) its vertices from the centre as they are seen: they stand on the ground [m].
    damping: while it touches a soft body [N s/m].
    skin: from what does not give, it keeps so far [m].
    """

    shape: RigidShape
    seen: Floats
    damping: float
    skin: float


class Collider(NamedTuple):
    """A mesh that bodies meet and that goes where it is led; it may be open, and both its sides count.

    positions: (3, m) [m].
    triangles: (t, 3) corners.
    friction: coefficient.
    falling: what it is where it falls; None: it is led.
    """

    positions: Floats
    triangles: Ints
    friction: float = 0.5
    falling: Falling | None = None


class ColliderMotion(NamedTuple):
    """Where a collider is led: an even way of each vertex from start to end, (3, m) [m]."""

    start: Floats
    end: Floats


class Fall(NamedTuple):
    """How a collider falls in a call: `state` is changed in place.

    gravity: (3,) [m/s2].
    ground: height of a plane [m], -inf where there is none.
    """

    state: RigidState
    gravity: Floats
    ground: float = -np.inf


Way = ColliderMotion | Fall | None  # of a collider in a call; None where one rests


class SceneFrame(NamedTuple):
    """What a call came to.

    frames: of each body.
    ticks: done.
    queries: of who is near whom.
    pairs: the most that were near each other.
    touching: the most that touched.
    truncated: times that a vertex was held back from passing through something.
    taken: momentum that this took [N s].
    held_back: the farthest that a collider was behind its way [m].
    gap: the least distance at a query [m], infinite where nothing was near.
    impulses: that each surface got from others [N s], (k, 3): bodies, then colliders.
    moments: of those about the origin [N m s], (k, 3).
    """

    frames: tuple[Frame, ...]
    ticks: int
    queries: int
    pairs: int
    touching: int
    truncated: int
    taken: float
    held_back: float
    gap: float
    impulses: Floats
    moments: Floats


class Crossings(NamedTuple):
    """What passes through each other: how many pairs of triangles, and of the first both surfaces and the place [m]."""

    pairs: int
    surfaces: tuple[int, int]
    place: tuple[float, float, float]
