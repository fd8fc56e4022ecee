"""Contact of bodies and colliders in the C library: the input and output of its calls, and the C structures."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence
from ctypes import Structure, addressof, byref, c_double, c_int64, c_uint8, c_void_p
from typing import NamedTuple

import numpy as np

from ..base import Bools, Floats, Ints
from ..body.rigid import RigidShape, RigidState
from ..constants import PASSED
from .body import Body, CFrame, CMotion, NativeError, call
from .definition import Arrays, fields
from .motion import Frame, Motion


class Falling(NamedTuple):
    """The rigid body of a collider that falls.

    shape: mass properties, and vertices of the contact surface.
    seen: (m, 3) vertices of the visible surface relative to the centre [m]; these stand on the ground.
    damping: damping while it touches a soft body [N s/m].
    skin: distance that it keeps from rigid surfaces [m]; those of two props add up.
    """

    shape: RigidShape
    seen: Floats
    damping: float
    skin: float


class Collider(NamedTuple):
    """A mesh that bodies collide with, on both sides; it may be open.

    positions: (3, m) [m].
    triangles: (t, 3) corners.
    friction: coefficient of friction.
    falling: its rigid body if it falls, None if its motion is prescribed.
    """

    positions: Floats
    triangles: Ints
    friction: float = 0.5
    falling: Falling | None = None


class ColliderMotion(NamedTuple):
    """The prescribed motion of a collider: each vertex moves uniformly from start to end, (3, m) [m]."""

    start: Floats
    end: Floats


class Fall(NamedTuple):
    """The motion of a prop in a call, which changes `state` in place.

    gravity: (3,) [m/s2].
    ground: height of the ground plane [m], -inf if there is none.
    """

    state: RigidState
    gravity: Floats
    ground: float = -np.inf


Way = ColliderMotion | Fall | None  # motion of a collider in a call; None if it rests


class SceneFrame(NamedTuple):
    """The result of a call.

    frames: the frame of each body.
    ticks: number of ticks done.
    queries: number of proximity queries.
    touching: largest number of pairs in contact.
    truncated: number of times that a vertex was stopped from passing through something.
    taken: momentum that these stops changed [N s].
    impulses: impulse on each surface from the others [N s], (k, 3): bodies, then colliders.
    moments: moments of these impulses about the origin [N m s], (k, 3).
    given: contact impulse on each vertex of all bodies [N s], (n, 3).
    late: distance of each surface behind its prescribed motion at the end [m], (k,).
    torn: whether each surface pulled the skin too far and was let go, until they are apart, (k,).
    places: place of the skin that held each surface back or that was let go [m], (k, 3).
    """

    frames: tuple[Frame, ...]
    ticks: int
    queries: int
    touching: int
    truncated: int
    taken: float
    impulses: Floats
    moments: Floats
    given: Floats
    late: Floats
    torn: Bools
    places: Floats


class Crossings(NamedTuple):
    """Intersections: the number of pairs of triangles, and the two surfaces and the place [m] of the first pair."""

    pairs: int
    surfaces: tuple[int, int]
    place: tuple[float, float, float]


class ColliderDef(Structure):
    """The definition of a collider: dm_collider_def."""

    _fields_ = fields(
        vertices="n", positions="p", triangles="n", corners="p", friction="d", mass="d", inverse_inertia="d9",
        damping="d", skin="d", arms="p", seen="p",
    )  # fmt: skip


class CProp(Structure):
    """The position and motion of a prop, its gravity and its ground: dm_prop."""

    _fields_ = fields(centre="d3", turn="d9", velocity="d3", momentum="d3", gravity="d3", ground="d")


class CColliderMotion(Structure):
    """The motion of a collider in a call: dm_collider_motion."""

    _fields_ = [("from_", c_void_p), ("to", c_void_p), ("prop", c_void_p)]


class CSceneFrame(Structure):
    """The result of a call: dm_scene_frame."""

    _fields_ = fields(
        ticks="n", queries="n", touching="n", truncated="n", taken="d"
    )


class CCrossings(Structure):
    """Intersections: dm_crossings."""

    _fields_ = [("count", c_int64), ("surfaces", c_int64 * 2), ("place", c_double * 3)]


class Scene:
    """Bodies and colliders in contact, in the C library, which frees them with this object; nothing passes through.

    Args:
        bodies: all of the same precision; their constants and positions may still be changed between two calls.
        colliders: meshes with a prescribed motion, or props.
        library: the C library.
        itself: whether each body has self contact; its faces that intersect each other now are left out of it.
        offsets: the distance [m] that each body keeps, 0 (the default) for a fraction of its mean edge; colliders keep
            the smallest of them.

    left_out: for each body, the intersections that are left out of its self contact.

    Raises:
        NativeError: the library refused the input.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        colliders: Sequence[Collider],
        library: ctypes.CDLL,
        *,
        itself: Sequence[bool],
        offsets: Sequence[float] = (),
    ) -> None:
        self._library, self.bodies, self._handle = library, list(bodies), c_void_p()
        self._shapes = [np.shape(collider.positions) for collider in colliders]
        handles = (c_void_p * len(bodies))(*(body.handle for body in bodies))
        flags, kept = (c_uint8 * len(bodies))(*itself), (c_double * len(bodies))(*offsets)
        out = (CCrossings * len(bodies))()
        with Arrays() as arrays:
            made = (ColliderDef * max(len(colliders), 1))(*(_collider(c, arrays) for c in colliders))
            call(
                library, "dm_scene_create", byref(self._handle), len(bodies), handles, flags, kept, len(colliders),
                made, out,
            )  # fmt: skip
        self.left_out = [_crossings(found) for found in out]
        weakref.finalize(self, library.dm_scene_destroy, self._handle.value)
        self._motions = (CMotion * len(bodies))()
        self._ways = (CColliderMotion * max(len(colliders), 1))()
        self._props = (CProp * max(len(colliders), 1))()
        self._frames, self._out = (CFrame * len(bodies))(), CSceneFrame()
        self._vertices = sum(len(body.model.mass) for body in bodies)
        self._passed = np.zeros((len(bodies) + len(colliders), PASSED))

    def step(
        self, motions: Sequence[Motion], ways: Sequence[Way], first: float, last: float
    ) -> SceneFrame:
        """Run motions, one for each body, that agree in number of ticks, substeps and length of the tick.

        Args:
            ways: motions of the colliders, None for one that rests; the state of a prop is changed in place.
            first, last: fraction of these motions that is done at the end of the first and of the last tick.

        Raises:
            NativeError: a motion contains a value that is not a number.
        """
        kept = [body.pack(motion, c) for body, motion, c in zip(self.bodies, motions, self._motions, strict=True)]
        given = np.empty((self._vertices, 3))
        with Arrays() as arrays:
            for way, to, prop, shape in zip(ways, self._ways, self._props, self._shapes, strict=False):
                to.from_ = to.to = to.prop = None
                if isinstance(way, Fall):
                    _rows_of(prop)[:] = _packed(way)
                    to.prop = addressof(prop)
                elif way is not None:
                    if np.shape(way.start) != shape or np.shape(way.end) != shape:
                        raise NativeError(f"a collider must have the shape {shape}")
                    to.from_, to.to = arrays.double(way.start), arrays.double(way.end)
            call(
                self._library, "dm_scene_step", self._handle, self._motions, self._ways, first, last, self._frames,
                byref(self._out), self._passed.ctypes.data, given.ctypes.data,
            )  # fmt: skip
        del kept
        for way, prop in zip(ways, self._props, strict=False):
            if isinstance(way, Fall):
                _unpack(_rows_of(prop), way.state)
        out = self._out
        frames = [b.unpack(m, f) for b, m, f in zip(self.bodies, motions, self._frames, strict=True)]
        passed = self._passed.copy()
        return SceneFrame(
            tuple(frames), out.ticks, out.queries, out.touching, out.truncated, out.taken,
            passed[:, :3], passed[:, 3:6], given, passed[:, 6], passed[:, 7] > 0, passed[:, 8:],
        )  # fmt: skip

    def crossings(self) -> Crossings:
        """Return the current intersections."""
        found = CCrossings()
        call(self._library, "dm_scene_find_crossings", self._handle, byref(found))
        return _crossings(found)

    def set_collider(self, index: int, positions: Floats) -> None:
        """Move a collider to positions (3, m) [m] instantly."""
        with Arrays() as arrays:
            at = arrays.double(positions)
            if np.shape(positions) != self._shapes[index]:
                raise NativeError(f"a collider must have the shape {self._shapes[index]}")
            call(self._library, "dm_scene_set_collider", self._handle, index, at)

    def collider(self, index: int) -> Floats:
        """Return the positions (3, m) [m] of a collider: behind its prescribed motion if something blocks it."""
        x = np.empty(self._shapes[index])
        call(self._library, "dm_scene_get_collider", self._handle, index, x.ctypes.data)
        return x


def _crossings(found: CCrossings) -> Crossings:
    a, b = found.surfaces
    x, y, z = found.place
    return Crossings(found.count, (a, b), (x, y, z))


def _collider(c: Collider, arrays: Arrays) -> ColliderDef:
    made = ColliderDef(
        c.positions.shape[1], arrays.double(c.positions), len(c.triangles), arrays.index(c.triangles), c.friction
    )
    if c.falling:
        shape = c.falling.shape
        made.mass, made.damping, made.skin = shape.mass, c.falling.damping, c.falling.skin
        made.inverse_inertia[:] = np.linalg.inv(shape.inertia).ravel().tolist()
        made.arms, made.seen = arrays.double(shape.arms.T), arrays.double(c.falling.seen.T)
    return made


def _rows_of(prop: CProp) -> Floats:
    return np.frombuffer(memoryview(prop).cast("B"), np.float64)


def _packed(fall: Fall) -> Floats:
    s = fall.state
    return np.concatenate([s.centre, s.turn.ravel(), s.velocity, s.momentum, fall.gravity, [fall.ground]])


def _unpack(row: Floats, state: RigidState) -> None:
    state.centre, state.turn = row[:3].copy(), row[3:12].reshape(3, 3).copy()
    state.velocity, state.momentum = row[12:15].copy(), row[15:18].copy()
