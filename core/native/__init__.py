"""The native core: the steps of `integrators.semi_implicit` in C, or the reason why they are not at hand.

The library lies beside this file (a developer's machine) or in the wheel `dimple_native` (an installed extension).
It is used only if its ABI number is this file's and a small body moves with it as it does with numpy.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import sys
import weakref
from pathlib import Path
from typing import Any

import numpy as np

from ..base import Floats
from ..body.model import Model, State
from ..solver import semi_implicit
from ..solver.path import FingerPath

ABI = 2
LIBRARY = {"win32": "dimple_core.dll", "darwin": "libdimple_core.dylib"}.get(sys.platform, "libdimple_core.so")
FILLS = {"none": 0, "air": 1, "liquid": 2, "paper": 3}
LAW_SETS = {"consistent": 0, "paper": 1}
BEST, BASE, AVX2 = 0, 1, 2  # instruction sets
NOT_A_NUMBER = 5  # DM_NUMBER
AGREEMENT = 1e-4  # of the size: what the self-test lets the library differ from numpy


class NativeError(RuntimeError):
    """Say which call the library refused, and why; code: its number in dimple.h, 0 for reasons of our own."""

    def __init__(self, reason: str, code: int = 0) -> None:
        super().__init__(reason)
        self.code = code


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


def run(model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats:
    """Advance a state in place in single precision, as `semi_implicit.run` does."""
    return run_body(body_of(model, 32), model, state, path, tick=tick, substeps=substeps)


def run64(model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats:
    """Advance a state in place in double precision."""
    return run_body(body_of(model, 64), model, state, path, tick=tick, substeps=substeps)


def load(path: Path) -> ctypes.CDLL:
    """Load a library and check its ABI number.

    Raises:
        OSError: it is broken or of another machine.  NativeError: it is of another version.
    """
    library = ctypes.CDLL(str(path))
    library.dm_abi.restype = ctypes.c_int32
    if library.dm_abi() != ABI:
        raise NativeError(f"it has version {library.dm_abi()}, not {ABI}")
    library.dm_message.restype = library.dm_instructions.restype = ctypes.c_char_p
    for name, arguments in ARGUMENTS.items():
        getattr(library, name).argtypes = [_TYPES[letter] for letter in arguments]
        getattr(library, name).restype = ctypes.c_int32
    return library


def use(own: ctypes.CDLL) -> None:
    """Run on this library from now on: a test's own build."""
    _bodies.clear()
    _loaded.append(own)


def self_test(library: ctypes.CDLL) -> None:
    """Press a small cube with the library and with numpy, in both precisions.

    Raises:
        NativeError: they differ.
    """
    model, state, path = small_press()
    semi_implicit.run(model, state, path, tick=1e-3, substeps=model.substeps(1e-3))
    for bits in (32, 64):
        model, other, path = small_press()
        run_body(Body(library, model, bits), model, other, path, tick=1e-3, substeps=model.substeps(1e-3))
        difference = float(np.abs(other.positions - state.positions).max())
        if not difference < AGREEMENT * model.mesh.size:
            raise NativeError(f"it differs from numpy by {1000 * difference:.3g} mm")


class Body:
    """Hold a model in the library; freed with this object.

    Args:
        bits: 32 or 64.
        instruction_set: BEST, or another where a test compares them.
    """

    def __init__(self, library: ctypes.CDLL, model: Model, bits: int, instruction_set: int = BEST) -> None:
        self.library = library
        self.handle = ctypes.c_uint64()
        self.n = len(model.mesh.rest_positions)
        rings, springs, matching, mesh = model.springs.rings, model.springs, model.matching, model.mesh
        width = len(rings.neighbours)
        handle = ctypes.byref(self.handle)
        rest = np.ascontiguousarray(mesh.rest_positions.T)
        self.call("dm_create", handle, bits, instruction_set, self.n, rest, width, rings.neighbours, rings.springs)
        weakref.finalize(self, library.dm_free, ctypes.c_uint64(self.handle.value))

        loose, ends = rings.irregular_springs, rings.irregular_ends
        if model.law_set == "paper":  # Eq. (4) goes spring by spring
            loose, ends = np.arange(len(springs.pairs)), np.ones((len(springs.pairs), 2), bool)
        else:
            own = loose < len(mesh.springs)
            loose, ends = loose[own], ends[own]
        constants = springs.pairs, springs.rest_lengths, springs.stiffness, springs.damping
        self.set("springs", len(springs.pairs), *constants, len(loose), loose, ends)
        self.set("bend", len(springs.pairs) - len(mesh.springs), *(a[len(mesh.springs) :] for a in constants))
        self.set("faces", len(mesh.triangles), mesh.triangles)
        fill, corners = model.pressure, rings.corners
        holes = len(fill.cap_edges), fill.cap_edges, fill.cap_loop
        self.set("fill", FILLS[fill.fill], fill.rest_volume, len(corners), corners, *holes)
        self.set("matter", self.n, matching.mass, model.inverse_mass, model.friction)
        self.set("memory", self.n, matching.k1, matching.k2, matching.d0, matching.damping)
        ground = -np.inf if model.ground is None else model.ground
        area = float(mesh.triangle_areas.sum())
        self.set("world", LAW_SETS[model.law_set], area, model.gravity, ground)

    def set(self, what: str, *values: Any) -> None:
        self.call(f"dm_set_{what}", self.handle, *values)

    def call(self, name: str, *values: Any) -> None:
        call(name, *values, using=self.library)


def call(name: str, *values: Any, using: ctypes.CDLL | None = None) -> None:
    """Call the library; numpy arrays go as the pointers its header asks for.

    Raises:
        NativeError: it refused.
    """
    arrays = []
    for letter, value in zip(ARGUMENTS[name], values, strict=True):
        if isinstance(value, np.ndarray):
            value = np.ascontiguousarray(value, _DTYPES[letter])
        arrays.append(value)
    using = using or library()
    # a third of the time .ctypes.data takes
    code = getattr(using, name)(*[a.__array_interface__["data"][0] if isinstance(a, np.ndarray) else a for a in arrays])
    if code:
        raise NativeError(f"{name}: {using.dm_message(code).decode()}", code)


def run_body(body: Body, model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats:
    """Advance a state of this body's model in place.

    Raises:
        NativeError: the arrays of the state are not contiguous doubles, or the library refused.
    """
    for a in (state.positions, state.velocities):
        if not (a.flags.c_contiguous and a.dtype == np.float64):
            raise NativeError("positions and velocities must be contiguous doubles, (3, n)")
    pose, pace = (p and np.concatenate([p[0].ravel(), p[1]]) for p in (state.pose, state.pace))
    try:
        body.set("state", body.n, state.positions, state.velocities, pose, pace)
    except NativeError as error:
        if error.code != NOT_A_NUMBER:
            raise
        state.positions[:] = np.nan  # it has blown up already, and stays so
        return np.zeros((len(path.radii), 3))
    if model.needs_contact:
        body.set("contact", state.inner_force, len(state.contact), state.contact)
    fingers, pressure = len(path.radii), ctypes.c_double()
    impulses = np.zeros((fingers, 3))
    ticks = path.centres.shape[1] - 1
    body.call("dm_step", body.handle, ticks, substeps, tick, fingers, path.centres, path.radii, impulses)
    body.call("dm_read", body.handle, body.n, state.positions, state.velocities, ctypes.byref(pressure))
    if model.law_set == "paper" or model.pressure.fill != "none":
        state.pressure = pressure.value
    if model.needs_contact:
        touched, count = np.empty(body.n, np.int64), ctypes.c_int64()
        body.call("dm_read_contact", body.handle, body.n, touched, ctypes.byref(count))
        state.contact = touched[: count.value].copy()
    return impulses


def body_of(model: Model, bits: int) -> Body:
    """Return the body of a model, made at its first use and freed with the model."""
    key = id(model), bits
    if key not in _bodies:
        _bodies[key] = Body(library(), model, bits)
        weakref.finalize(model, _bodies.pop, key, None)
    return _bodies[key]


def small_press() -> tuple[Model, State, FingerPath]:
    """Return a soft octahedron on the ground, its fingertip and a few ticks of its way down."""
    from ..body.model import build_model, initial_state
    from ..material import Material
    from ..mesh.surface import mesh_from_triangles

    corners = np.concatenate([np.eye(3), -np.eye(3)]) * 0.05
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    mesh = mesh_from_triangles(corners, faces)
    model = build_model(
        mesh, [Material(K1=600, K2=7000, x0=0.01, k=600, mass=0.1)], gravity=(0, 0, -9.81), ground=-0.05
    )
    centres = np.zeros((1, 11, 3))
    centres[0, :, :2] = (0.003, 0.001)
    centres[0, :, 2] = np.linspace(0.0605, 0.0585, 11)
    return model, initial_state(model), FingerPath(centres=centres, radii=np.array([0.01]))


_loaded: list[ctypes.CDLL] = []
_bodies: dict[tuple[int, int], Body] = {}

# dimple.h, a letter an argument: b body, o its address, i int32, n int64, d double, D I U arrays, p address of a number
_TYPES: dict[str, Any] = {
    "b": ctypes.c_uint64, "o": ctypes.c_void_p, "i": ctypes.c_int32, "n": ctypes.c_int64, "d": ctypes.c_double,
    "D": ctypes.c_void_p, "I": ctypes.c_void_p, "U": ctypes.c_void_p, "p": ctypes.c_void_p,
}  # fmt: skip
_DTYPES: dict[str, type] = {"D": np.float64, "I": np.int64, "U": np.uint8}
ARGUMENTS = {
    "dm_create": "oiinDnII", "dm_free": "b", "dm_fit_rotation": "DD",
    "dm_set_springs": "bnIDDDnIU", "dm_set_bend": "bnIDDD", "dm_set_faces": "bnI", "dm_set_fill": "bidnInII",
    "dm_set_matter": "bnDDD", "dm_set_memory": "bnDDDD", "dm_set_world": "bidDd",
    "dm_set_state": "bnDDDD", "dm_set_contact": "bdnI", "dm_step": "bnndnDDD", "dm_read": "bnDDp",
    "dm_read_contact": "bnIp",
}  # fmt: skip
