"""The native core: bodies that own their state in C, or the reason why there are none here.

The library lies beside this file (a developer's machine) or in the wheel `dimple_native` (an installed extension).
It is used only if its ABI number is this file's and a small body moves in it as its numpy twin does.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import struct
import sys
import weakref
from ctypes import POINTER, Structure, byref, c_double, c_int32, c_int64, c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from ..base import Floats
from ..body.model import Model
from ..solver.motion import Frame, Motion, Touch
from ..solver.twin import Twin

ABI = 4
LIBRARY = {"win32": "dimple_core.dll", "darwin": "libdimple_core.dylib"}.get(sys.platform, "libdimple_core.so")
FILLS = {"none": 0, "air": 1, "liquid": 2}
LAW_SETS = {"consistent": 0, "paper": 1}
BEST, BASE, AVX2 = 0, 1, 2  # instruction sets
AGREEMENT = 1e-4  # of the size: what the self-test lets the library differ from numpy


class NativeError(RuntimeError):
    """A call that the library refused, and why. code: its number in dimple.h, 0 for reasons of this file."""

    def __init__(self, reason: str, code: int = 0) -> None:
        super().__init__(reason)
        self.code = code


# the structures of dimple.h, field by field (tests/parity/test_door.py compares them)
_TYPES: dict[str, Any] = {"p": c_void_p, "n": c_int64, "i": c_int32, "d": c_double}


def _fields(**kinds: str) -> list[tuple[str, Any]]:
    """Return the fields of a structure: p array, n int64, i int32, d double, d3 three of them..."""
    return [(name, _TYPES[kind[0]] * int(kind[1:]) if kind[1:] else _TYPES[kind]) for name, kind in kinds.items()]


class Constants(Structure):
    """The numbers of a body that may change while it lives: dm_constants."""

    _fields_ = _fields(
        stiffness="p", damping="p", tension="p", mass="p", inverse_mass="p", friction="p", k1="p", k2="p", d0="p", drag="p",
        laws="p", materials="n", gravity="d3", ground="d", law_set="i", fill="i", free="i",
    )  # fmt: skip


class BodyDef(Structure):
    """What a body is: dm_body_def."""

    _fields_ = _fields(
        vertices="n", rest="p", loose="p", width="n", ring="p", ring_spring="p", springs="n", ends="p",
        rest_length="p", irregular="n", irregular_spring="p", irregular_end="p", triangles="n", corners="p",
        fans="n", fan="p", cap_edges="n", cap_edge="p", cap_hole="p", rest_volume="d", rest_area="d", size="d",
        surface_vertices="n", surface_rest="p", surface_triangles="n", surface_corners="p", surface_material="p",
    ) + [("constants", Constants)]  # fmt: skip


class Fingertip(Structure):
    """Where one fingertip goes during a call: dm_fingertip."""

    _fields_ = _fields(first="d3", last="d3", radius="d", contact_radius="d", down="n", fresh="n")
    _fields_.insert(0, ("from_", c_double * 3))


class CMotion(Structure):
    """What happens to a body during a call: dm_motion."""

    _fields_ = [
        *_fields(ticks="n", substeps="n", tick="d"),
        ("fingertips", Fingertip * 3),
        *_fields(pins_from="p", pins_to="p", pins_first="d", pins_last="d"),
    ]


class CTouch(Structure):
    """How a fingertip meets a body: dm_touch."""

    _fields_ = _fields(impulse="d3", centre="d3", depth="d", outward="d3", law_force="d", triangle="n")


_RESULT = _fields(pose="d12", volume="d", pressure="d", ticks="n", finite="n")


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


_SIGNATURES: dict[str, tuple[Any, ...]] = {
    "dm_create": (POINTER(c_void_p), POINTER(BodyDef), c_int32, c_int32),
    "dm_set_constants": (c_void_p, POINTER(Constants)),
    "dm_set_state": (c_void_p, c_void_p, c_void_p),
    "dm_get_state": (c_void_p, c_void_p, c_void_p),
    "dm_step": (c_void_p, POINTER(CMotion), POINTER(CFrame)),
    "dm_fit_rotation": (c_void_p, c_void_p),
}


def places() -> list[Path]:
    """Return where the library may be, the first first."""
    wheel = importlib.util.find_spec("dimple_native")
    folders = [Path(__file__).parent, *map(Path, (wheel and wheel.submodule_search_locations) or ())]
    return [folder / LIBRARY for folder in folders]


@functools.cache
def why_not() -> str:
    """Return "" where the native core can run, else a sentence for the artist. The first call tests it."""
    if _loaded:
        return ""
    found = [path for path in places() if path.exists()]
    if not found:
        return "Runs on numpy, slower: this installation has no native core for this machine."
    try:
        library = load(found[0])
        self_test(library)
    except (OSError, AttributeError, NativeError) as error:
        return f"Runs on numpy, slower: the native core was refused ({error})."
    _loaded.append(library)
    return ""


def library() -> ctypes.CDLL:
    """Return the library in use.

    Raises:
        NativeError: there is none.
    """
    if not _loaded and why_not():
        raise NativeError(why_not())
    return _loaded[-1]


def instructions(instruction_set: int = BEST) -> str:
    """Return the name of an instruction set, "" where this machine lacks it."""
    name: bytes = library().dm_instructions(instruction_set)
    return name.decode()


def load(path: Path) -> ctypes.CDLL:
    """Load a library and check its ABI number.

    Raises:
        OSError: it is broken or of another machine.  NativeError: it is of another version.
    """
    library = ctypes.CDLL(str(path))
    library.dm_abi.restype = c_int32
    if library.dm_abi() != ABI:
        raise NativeError(f"it has version {library.dm_abi()}, not {ABI}")
    library.dm_message.restype = library.dm_instructions.restype = ctypes.c_char_p
    library.dm_destroy.argtypes, library.dm_destroy.restype = [c_void_p], None
    library.dm_default_body_def.argtypes, library.dm_default_body_def.restype = [POINTER(BodyDef)], None
    for name, arguments in _SIGNATURES.items():
        getattr(library, name).argtypes = arguments
        getattr(library, name).restype = c_int32
    return library


def use(own: ctypes.CDLL) -> None:
    """Run on this library from now on: a test's own build."""
    _loaded.append(own)


def self_test(library: ctypes.CDLL) -> None:
    """Press a small cube in the library and in numpy, in both precisions.

    Raises:
        NativeError: they differ.
    """
    model, motion = small_press()
    twin = Twin(model)
    twin.step(motion)
    for bits in (32, 64):
        body = Body(model, bits=bits, using=library)
        body.step(motion)
        difference = float(np.abs(body.positions() - twin.positions()).max())
        if not difference < AGREEMENT * model.mesh.size:
            raise NativeError(f"it differs from numpy by {1000 * difference:.3g} mm")


class Body:
    """A body in the library, which owns its state; freed with this object. Its twin is `solver.twin.Twin`.

    Args:
        model: what moves.
        surface: the model below whose surface at rest fingertips are measured, where `model` is its proxy.
        bits: 32 or 64, of the state.
        instruction_set: BEST, or another where a test compares them.
        using: the library, where it is not the one in use.

    Raises:
        NativeError: the library refused it.
    """

    def __init__(
        self,
        model: Model,
        *,
        surface: Model | None = None,
        bits: int = 32,
        instruction_set: int = BEST,
        using: ctypes.CDLL | None = None,
    ) -> None:
        self.library = using or library()
        self.model, self._surface = model, surface or model
        self._shape = model.matching.rest.shape
        self._placed: Floats | None = model.matching.rest  # what has not been stepped since keeps its digits
        self._motion, self._frame, self._handle = CMotion(), CFrame(), c_void_p()
        with _Arrays() as arrays:
            definition = _definition(self.library, model, self._surface, arrays)
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
        with _Arrays() as arrays:
            self._call("dm_set_constants", self._handle, byref(_constants(model, surface, arrays)))
        self.model, self._surface = model, surface

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Put the vertices at positions (3, n) [m] with velocities (3, n) [m/s], the shape at rest at rest."""
        with _Arrays() as arrays:
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


class _Arrays:
    """Keep arrays alive, contiguous and of the right type, while the library reads them."""

    def __init__(self) -> None:
        self._kept: list[Any] = []

    def __enter__(self) -> _Arrays:
        return self

    def __exit__(self, *_: object) -> None:
        self._kept.clear()

    def of(self, array: Any, dtype: Any) -> int:
        """Return the address of an array."""
        array = np.ascontiguousarray(array, dtype)
        self._kept.append(array)
        return int(array.ctypes.data)

    def double(self, array: Any) -> int | None:
        """Return the address of an array of doubles, None for None."""
        return None if array is None else self.of(array, np.float64)

    def index(self, array: Any) -> int:
        """Return the address of an array of indices."""
        return self.of(array, np.int64)


def _definition(library: ctypes.CDLL, model: Model, surface: Model, arrays: _Arrays) -> BodyDef:
    """Return what the library asks for of a model."""
    definition, mesh, springs = BodyDef(), model.mesh, model.springs
    library.dm_default_body_def(byref(definition))
    rings = springs.rings
    values = {
        "vertices": len(mesh.rest_positions), "rest": arrays.double(mesh.rest_positions.T),
        "loose": arrays.of(mesh.loose, np.uint8),
        "width": len(rings.neighbours), "ring": arrays.index(rings.neighbours),
        "ring_spring": arrays.index(rings.springs),
        "springs": len(springs.pairs), "ends": arrays.index(springs.pairs),
        "rest_length": arrays.double(springs.rest_lengths),
        "irregular": len(rings.irregular_springs), "irregular_spring": arrays.index(rings.irregular_springs),
        "irregular_end": arrays.of(rings.irregular_ends, np.uint8),
        "triangles": len(mesh.triangles), "corners": arrays.index(mesh.triangles),
        "fans": len(rings.corners), "fan": arrays.index(rings.corners),
        "cap_edges": len(mesh.cap_edges), "cap_edge": arrays.index(mesh.cap_edges),
        "cap_hole": arrays.index(mesh.cap_loop),
        "rest_volume": model.pressure.rest_volume, "rest_area": float(mesh.triangle_areas.sum()), "size": mesh.size,
        "surface_vertices": len(surface.mesh.rest_positions),
        "surface_rest": arrays.double(surface.mesh.rest_positions.T),
        "surface_triangles": len(surface.mesh.triangles), "surface_corners": arrays.index(surface.mesh.triangles),
        "surface_material": arrays.index(surface.mesh.triangle_material),
        "constants": _constants(model, surface, arrays),
    }  # fmt: skip
    for name, value in values.items():
        setattr(definition, name, value)
    return definition


def _constants(model: Model, surface: Model, arrays: _Arrays) -> Constants:
    matching = model.matching
    return Constants(
        stiffness=arrays.double(model.springs.stiffness), damping=arrays.double(model.springs.damping),
        tension=arrays.double(matching.tension), mass=arrays.double(matching.mass), inverse_mass=arrays.double(model.inverse_mass),
        friction=arrays.double(model.friction), k1=arrays.double(matching.k1), k2=arrays.double(matching.k2),
        d0=arrays.double(matching.d0), drag=arrays.double(matching.damping),
        laws=arrays.double([(m.K1, m.K2, m.x0) for m in surface.materials]), materials=len(surface.materials),
        gravity=(c_double * 3)(*model.gravity), ground=-np.inf if model.ground is None else model.ground,
        law_set=LAW_SETS[model.law_set], fill=FILLS[model.pressure.fill], free=model.free,
    )  # fmt: skip


def small_press() -> tuple[Model, Motion]:
    """Return a soft octahedron on the ground and a few ticks of a fingertip's way into it."""
    from ..body.model import build_model
    from ..material import Material
    from ..mesh.surface import mesh_from_triangles
    from ..solver.motion import FingertipMotion

    corners = np.concatenate([np.eye(3), -np.eye(3)]) * 0.05
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    mesh = mesh_from_triangles(corners, faces)
    model = build_model(
        mesh, [Material(K1=600, K2=7000, x0=0.01, k=600, mass=0.1)], gravity=(0, 0, -9.81), ground=-0.05
    )
    tip = FingertipMotion.straight((0.003, 0.001, 0.0605), (0.003, 0.001, 0.0585), ticks=10, radius=0.01)
    return model, Motion(ticks=10, substeps=model.substeps(1e-3), tick=1e-3, fingertips=(tip,))


_loaded: list[ctypes.CDLL] = []
