"""A body that owns its state in the library, and the structures of dimple.h that control and read it."""

from __future__ import annotations

import ctypes
import struct
import weakref
from collections.abc import Sequence
from ctypes import Structure, addressof, byref, c_double, c_void_p
from typing import Any

import numpy as np

from ..base import Floats
from ..body.model import Model
from ..constants import MAX_FINGERTIPS
from .definition import Arrays, constants, define, fields
from .motion import Frame, Motion, PinMotion, Touch

BEST, BASE, AVX2 = range(3)  # instruction sets


class NativeError(RuntimeError):
    """A call that was refused, and why. code: the library's code of dimple.h, 0 if Python refused the call."""

    def __init__(self, reason: str, code: int = 0) -> None:
        super().__init__(reason)
        self.code = code


def call(library: ctypes.CDLL, name: str, *values: Any) -> None:
    """Call a function of the library that returns a code.

    Raises:
        NativeError: it refused.
    """
    code = getattr(library, name)(*values)
    if code:
        raise NativeError(f"{name}: {library.dm_message(code).decode()}", code)


class Fingertip(Structure):
    """The motion of one fingertip during a call: dm_fingertip."""

    _fields_ = fields(
        first="d3", last="d3", radius="d", force="d", inward="d3", factors="p", factors_end="d", down="n", fresh="n"
    )
    _fields_.insert(0, ("from_", c_double * 3))


class CMotion(Structure):
    """The motion imposed on a body during a call: dm_motion."""

    _fields_ = [
        *fields(ticks="n", substeps="n", tick="d"),
        ("fingertips", Fingertip * MAX_FINGERTIPS),
        *fields(pins_from="p", pins_to="p", pins_first="d", pins_last="d"),
    ]


class CTouch(Structure):
    """The contact of a fingertip with a body: dm_touch."""

    _fields_ = fields(
        impulse="d3", centre="d3", depth="d", outward="d3", force="d3", slope="d", friction="d", law="d4", triangle="n"
    )


class CFrame(Structure):
    """The result of a call: dm_frame."""

    _fields_ = [
        ("touches", CTouch * MAX_FINGERTIPS),
        *fields(volume="d", pressure="d", ticks="n", finite="n", moved="n"),
    ]


def _letters(kind: Any) -> str:
    """Return the format characters of the module struct for a ctypes type."""
    if issubclass(kind, Structure):
        return "".join(_letters(each) for _, each, *_ in kind._fields_)
    return _letters(kind._type_) * kind._length_ if issubclass(kind, ctypes.Array) else kind._type_


def _packed(kind: Any, each: Any) -> list[struct.Struct]:
    """Return the layouts of a structure as flat numbers with only its first 0, 1, 2 or 3 fingertips or touches."""
    numbers, size = _letters(each), ctypes.sizeof(each)
    return [
        struct.Struct(_letters(kind).replace(3 * numbers, f"{count * numbers}{(3 - count) * size}x"))
        for count in range(4)
    ]


# whole structures, written and read as flat numbers: far faster than field by field
_PACKED_MOTION, _PACKED_FRAME = _packed(CMotion, Fingertip), _packed(CFrame, CTouch)
_TIP_NUMBERS, _TOUCH_NUMBERS = len(_letters(Fingertip)), len(_letters(CTouch))


class Body:
    """A body in the library, which owns its state; freed with this object.

    Args:
        model: the simulated model.
        library: the library that runs it.
        surface: model from whose surface at rest the depths of fingertips are measured, if `model` is its proxy.
        bits: 32 or 64, precision of the state.
        instruction_set: BEST, or another if a test compares them.

    handle: the body in the library, for a scene of several.

    Raises:
        NativeError: the library refused it.
    """

    def __init__(
        self,
        model: Model,
        library: ctypes.CDLL,
        *,
        surface: Model | None = None,
        bits: int = 32,
        instruction_set: int = BEST,
    ) -> None:
        self.library = library
        self.model, self._surface = model, surface or model
        self._shape, self._pinned = model.matching.rest.shape, int(model.pinned.sum())
        self._placed: Floats | None = model.matching.rest  # positions of the vertices, None if unknown
        self._motion, self._frame, self.handle = CMotion(), CFrame(), c_void_p()
        with Arrays() as arrays:
            definition = define(self.library, model, self._surface, arrays)
            call(self.library, "dm_create", byref(self.handle), byref(definition), bits, instruction_set)
        weakref.finalize(self, self.library.dm_destroy, self.handle.value)
        # the arguments of every step, made once
        self._step = self.library.dm_step
        self._step_arguments = self.handle, byref(self._motion), byref(self._frame)

    def set_constants(self, model: Model, *, surface: Model | None = None) -> None:
        """Give the living body the constants of other models of the same meshes.

        Args:
            surface: as in the constructor.

        Raises:
            NativeError: an invalid number, or another mesh.
        """
        surface = surface or model
        if model.mesh is not self.model.mesh or surface.mesh is not self._surface.mesh:
            raise NativeError("the model is of another mesh")
        with Arrays() as arrays:
            call(self.library, "dm_set_constants", self.handle, byref(constants(model, surface, arrays)))
        self.model, self._surface, self._pinned = model, surface, int(model.pinned.sum())

    def set_rest(
        self, rest: Floats, rate: Floats | None = None, *, surface: Floats | None = None, gain: Floats | None = None
    ) -> None:
        """Give the living body another shape at rest (3, n) [m], and with it rest lengths and volume.

        Args:
            rate: velocity (3, n) at which it gets there during the next motion [m/s]; None: at once.
            surface: surface at rest (3, m) from which depths of fingertips are measured, if the body is a proxy [m].
            gain: (3, n) added to the velocities of its vertices [m/s].

        Raises:
            NativeError: an invalid number, or a proxy without its surface.
        """
        with Arrays() as arrays:
            if any(np.shape(each) != self._shape for each in (rest, rate, gain) if each is not None):
                raise NativeError(f"the shape at rest must have the shape {self._shape}")
            if surface is not None and np.shape(surface) != self._surface.matching.rest.shape:
                raise NativeError("the surface has another number of vertices")
            given = [arrays.double(each) for each in (rest, surface, rate, gain)]
            call(self.library, "dm_set_rest", self.handle, *given)

    def wake(self) -> None:
        """Let a sleeping body move again: what it rested on may be gone."""
        call(self.library, "dm_wake_body", self.handle)

    @property
    def rest_volume(self) -> float:
        """Return the volume at rest [m3]."""
        return float(self.library.dm_rest_volume(self.handle))

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Set the positions (3, n) [m] and velocities (3, n) [m/s] of the vertices, and stop the shape at rest."""
        with Arrays() as arrays:
            at, speed = (arrays.double(a) for a in (positions, velocities))
            if np.shape(positions) != self._shape or (velocities is not None and np.shape(velocities) != self._shape):
                raise NativeError(f"the state must have the shape {self._shape}")
            call(self.library, "dm_set_state", self.handle, at, speed)
        self._placed = np.array(positions, np.float64)

    def positions(self) -> Floats:
        """Return the positions of the vertices (3, n) [m]."""
        if self._placed is None:
            self._placed = np.empty(self._shape)
            call(self.library, "dm_get_state", self.handle, self._placed.ctypes.data, None)
        return self._placed.copy()

    def velocities(self) -> Floats:
        """Return the velocities of the vertices (3, n) [m/s]."""
        v = np.empty(self._shape)
        call(self.library, "dm_get_state", self.handle, None, v.ctypes.data)
        return v

    def step(self, motion: Motion) -> Frame:
        """Run the ticks of a motion.

        Raises:
            NativeError: the motion has an invalid number.
        """
        pins = self.pack(motion, self._motion)  # kept alive until the call returns
        code = self._step(*self._step_arguments)
        del pins
        if code:
            raise NativeError(f"dm_step: {self.library.dm_message(code).decode()}", code)
        return self.unpack(motion, self._frame)

    def law(self, fingertip: int, depths: Floats, factors: tuple[Floats, float] | None = None) -> Floats:
        """Return the forces (d,) [N] of the law that a fingertip would get at depths (d,) [m] at its place.

        Args:
            factors: as in its motion.

        Raises:
            NativeError: no such fingertip, or an invalid number.
        """
        table, end = factors or (None, 0.0)
        with Arrays() as arrays:
            at, forces = arrays.double(depths), np.empty(len(depths))
            row = arrays.double(table)
            call(self.library, "dm_get_law", self.handle, fingertip, row, end, len(depths), at, forces.ctypes.data)
        return forces

    def pack(self, motion: Motion, to: CMotion) -> list[Floats]:
        """Write a motion in the layout of the library; return the arrays it points to."""
        ticks, substeps, tick, tips, pins = motion
        numbers: list[Any] = [ticks, substeps, tick]
        arrays: list[Floats] = []
        for tip in tips:
            if tip is None:
                numbers += [0] * _TIP_NUMBERS  # lifted
            else:
                start, first, last, radius, fresh, force, inward, factors = tip
                table, end = factors or (None, 0.0)
                if table is not None:
                    arrays.append(table := np.ascontiguousarray(table, np.float64))
                place = 0 if table is None else table.ctypes.data
                numbers += (*start, *first, *last, radius, force, *inward, place, end, True, fresh)
        if pins is None:
            numbers += [0, 0, 0, 0]
        else:
            places = self._places(pins)
            numbers += (*(a.ctypes.data for a in places), pins.first, pins.last)
            arrays += places
        _PACKED_MOTION[len(tips)].pack_into(to, 0, *numbers)
        return arrays

    def unpack(self, motion: Motion, frame: CFrame) -> Frame:
        """Return the result of a motion that has been run."""
        tips = motion.fingertips
        a = _PACKED_FRAME[len(tips)].unpack_from(frame)
        touches: list[Touch | None] = []
        for tip in tips:
            i = len(touches) * _TOUCH_NUMBERS
            touch = Touch(
                a[i : i + 3], a[i + 3 : i + 6], a[i + 6], a[i + 7 : i + 10], a[i + 10 : i + 13], a[i + 13], a[i + 14],
                a[i + 15 : i + 19], a[i + 19],
            )  # fmt: skip
            touches.append(touch if tip else None)
        volume, pressure, ticks, finite, moved = a[-5:]
        if moved:
            self._placed = None
        return Frame(tuple(touches), volume, pressure, ticks, finite != 0, moved != 0)

    def _places(self, pins: PinMotion) -> list[Floats]:
        """Return the start and end positions of pins, as the library reads them."""
        shape = 3, self._pinned
        arrays = [np.ascontiguousarray(a, np.float64) for a in (pins.start, pins.end)]
        if arrays[0].shape != shape or arrays[1].shape != shape:
            raise NativeError(f"the places of the pins must have the shape {shape}")
        return arrays


def step_many(bodies: Sequence[Body], motions: Sequence[Motion]) -> list[Frame]:
    """Run one motion for each of several bodies of one library; the results are those of `Body.step`, bit for bit.

    Raises:
        NativeError: a motion has an invalid number, or a body appears twice; no body has moved.
    """
    if len(bodies) <= 1:  # a direct call is faster
        return [body.step(motion) for body, motion in zip(bodies, motions, strict=True)]
    library, count = bodies[0].library, len(bodies)
    kept = [body.pack(motion, body._motion) for body, motion in zip(bodies, motions, strict=True)]
    places = [(body.handle.value, addressof(body._motion), addressof(body._frame)) for body in bodies]
    columns = [(c_void_p * count)(*column) for column in zip(*places, strict=True)]
    call(library, "dm_step_many", count, *columns)
    del kept
    return [body.unpack(motion, body._frame) for body, motion in zip(bodies, motions, strict=True)]
