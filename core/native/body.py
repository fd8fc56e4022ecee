"""A body that owns its state in the library, and the structures of dimple.h by which it is moved and read."""

from __future__ import annotations

import ctypes
import struct
import weakref
from ctypes import Structure, byref, c_double, c_int64, c_void_p
from typing import Any

import numpy as np

from ..base import Floats
from ..body.model import Model
from ..solver.motion import Frame, Motion, Touch
from .definition import Arrays, constants, define, fields

BEST, BASE, AVX2 = 0, 1, 2  # instruction sets


class NativeError(RuntimeError):
    """A call that the library refused, and why. code: its number in dimple.h, 0 for reasons of Python's."""

    def __init__(self, reason: str, code: int = 0) -> None:
        super().__init__(reason)
        self.code = code


class Fingertip(Structure):
    """Where one fingertip goes during a call: dm_fingertip."""

    _fields_ = fields(first="d3", last="d3", radius="d", contact_radius="d", down="n", fresh="n")
    _fields_.insert(0, ("from_", c_double * 3))


class CMotion(Structure):
    """What happens to a body during a call: dm_motion."""

    _fields_ = [
        *fields(ticks="n", substeps="n", tick="d"),
        ("fingertips", Fingertip * 3),
        *fields(pins_from="p", pins_to="p", pins_first="d", pins_last="d"),
    ]


class CTouch(Structure):
    """How a fingertip meets a body: dm_touch."""

    _fields_ = fields(impulse="d3", centre="d3", depth="d", outward="d3", law_force="d", triangle="n")


_RESULT = fields(pose="d12", volume="d", pressure="d", ticks="n", finite="n")


class CFrame(Structure):
    """What a call came to: dm_frame."""

    _fields_ = [("touches", CTouch * 3), *_RESULT]


def _packed(fields: list[tuple[str, Any]]) -> struct.Struct:
    """Return what reads or writes such fields at once, as flat numbers: far faster than one by one."""
    words = {c_double: "d", c_int64: "q"}
    return struct.Struct("".join(words.get(kind) or f"{kind._length_}{words[kind._type_]}" for _, kind in fields))


_PACKED_FINGERTIP, _PACKED_TOUCH, _PACKED_RESULT = map(_packed, (Fingertip._fields_, CTouch._fields_, _RESULT))
_FINGERTIPS_AT = [CMotion.fingertips.offset + i * ctypes.sizeof(Fingertip) for i in range(3)]
_TOUCHES_AT = [CFrame.touches.offset + i * ctypes.sizeof(CTouch) for i in range(3)]
_LIFTED = [0.0] * 11 + [0, 0]


class Body:
    """A body in the library, which owns its state; freed with this object. Its twin is `solver.twin.Twin`.

    Args:
        model: what moves.
        library: that runs it.
        surface: the model below whose surface at rest fingertips are measured, where `model` is its proxy.
        bits: 32 or 64, of the state.
        instruction_set: BEST, or another where a test compares them.

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
        self._shape = model.matching.rest.shape
        self._placed: Floats | None = model.matching.rest  # what has not been stepped since keeps its digits
        self._motion, self._frame, self._handle = CMotion(), CFrame(), c_void_p()
        with Arrays() as arrays:
            definition = define(self.library, model, self._surface, arrays)
            self._call("dm_create", byref(self._handle), byref(definition), bits, instruction_set)
        weakref.finalize(self, self.library.dm_destroy, self._handle.value)
        # what every step hands over: made once
        self._step = self.library.dm_step
        self._step_arguments = self._handle, byref(self._motion), byref(self._frame)

    def set_constants(self, model: Model, *, surface: Model | None = None) -> None:
        """Give the living body the numbers of other models of the same meshes.

        Args:
            surface: as at the start; left out, a proxy keeps the one it has.

        Raises:
            NativeError: a number that is none, or another mesh.
        """
        surface = surface or (model if self._surface is self.model else self._surface)
        if model.mesh is not self.model.mesh or surface.mesh is not self._surface.mesh:
            raise NativeError("the model is of another mesh")
        with Arrays() as arrays:
            self._call("dm_set_constants", self._handle, byref(constants(model, surface, arrays)))
        self.model, self._surface = model, surface

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Put the vertices at positions (3, n) [m] with velocities (3, n) [m/s], the shape at rest at rest."""
        with Arrays() as arrays:
            at, speed = (arrays.double(a) for a in (positions, velocities))
            if np.shape(positions) != self._shape or (velocities is not None and np.shape(velocities) != self._shape):
                raise NativeError(f"the state must have the shape {self._shape}")
            self._call("dm_set_state", self._handle, at, speed)
        self._placed = np.array(positions, np.float64)

    def positions(self) -> Floats:
        """Return where the vertices are, (3, n) [m]."""
        if self._placed is not None:
            return self._placed.copy()
        x = np.empty(self._shape)
        self._call("dm_get_state", self._handle, x.ctypes.data, None)
        return x

    def velocities(self) -> Floats:
        """Return how fast the vertices move, (3, n) [m/s]."""
        v = np.empty(self._shape)
        self._call("dm_get_state", self._handle, None, v.ctypes.data)
        return v

    def step(self, motion: Motion) -> Frame:
        """Run the ticks of a motion.

        Raises:
            NativeError: the motion has a number that is none.
        """
        given, frame = self._motion, self._frame
        if motion.ticks:
            self._placed = None
        given.ticks, given.substeps, given.tick = motion.ticks, motion.substeps, motion.tick
        tips = motion.fingertips
        for at, tip in zip(_FINGERTIPS_AT, tips + (None,) * (3 - len(tips)), strict=True):
            values = _LIFTED if tip is None else (
                *tip.start, *tip.first, *tip.last, tip.radius, tip.contact_radius, True, tip.fresh,
            )  # fmt: skip
            _PACKED_FINGERTIP.pack_into(given, at, *values)
        arrays = None
        if motion.pins is not None:
            pins, shape = motion.pins, (3, int(self.model.held.sum()))
            arrays = [np.ascontiguousarray(a, np.float64) for a in (pins.start, pins.end)]
            if arrays[0].shape != shape or arrays[1].shape != shape:
                raise NativeError(f"the places of the pins must have the shape {shape}")
            given.pins_from, given.pins_to = (a.ctypes.data for a in arrays)
            given.pins_first, given.pins_last = pins.first, pins.last
        else:
            given.pins_from = given.pins_to = None
        code = self._step(*self._step_arguments)
        if code:
            raise NativeError(f"dm_step: {self.library.dm_message(code).decode()}", code)
        touches = tuple([_touch(frame, at) if tip else None for at, tip in zip(_TOUCHES_AT, tips, strict=False)])
        *pose, volume, pressure, ticks, finite = _PACKED_RESULT.unpack_from(frame, CFrame.pose.offset)
        return Frame(touches, tuple(pose), volume, pressure, ticks, bool(finite))

    def _call(self, name: str, *values: Any) -> None:
        code = getattr(self.library, name)(*values)
        if code:
            raise NativeError(f"{name}: {self.library.dm_message(code).decode()}", code)


def _touch(frame: CFrame, at: int) -> Touch:
    values = _PACKED_TOUCH.unpack_from(frame, at)
    return Touch(values[:3], values[3:6], values[6], values[7:10], values[10], values[11])
