"""The native core: the library, found, loaded and tested, or the reason why there is none here.

The library lies beside this file (a developer's machine) or in the wheel `dimple_native` (an installed extension).
It is used only if its ABI number is this file's and a small body moves in it as its numpy twin does.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import sys
from ctypes import POINTER, c_double, c_int32, c_int64, c_uint8, c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from ..body.model import Model
from ..solver.motion import Motion
from ..solver.twin import Twin
from .body import AVX2 as AVX2
from .body import BASE as BASE
from .body import BEST as BEST
from .body import Body as Body
from .body import NativeError as NativeError
from .body import step_many as step_many
from .carry import Binding as Binding
from .carry import CBinding, CKept
from .carry import carry as carry
from .carry import carry_moved as carry_moved
from .cells import CCells
from .cells import farthest_first as farthest_first
from .cells import follow_cells as follow_cells
from .cells import grow_cells as grow_cells
from .definition import BodyDef, Constants
from .scene import CCrossings, ColliderDef
from .scene import Scene as Scene

ABI = 24
LIBRARY = {"win32": "dimple_core.dll", "darwin": "libdimple_core.dylib"}.get(sys.platform, "libdimple_core.so")
AGREEMENT = 1e-4  # of the size: what the self-test lets the library differ from numpy

_SIGNATURES: dict[str, tuple[Any, ...] | None] = {  # fmt: skip
    "dm_create": (POINTER(c_void_p), POINTER(BodyDef), c_int32, c_int32),
    "dm_set_constants": (c_void_p, POINTER(Constants)),
    "dm_set_rest": (c_void_p, c_void_p, c_void_p),
    "dm_wake_body": (c_void_p,),
    "dm_set_state": (c_void_p, c_void_p, c_void_p),
    "dm_get_state": (c_void_p, c_void_p, c_void_p),
    "dm_step": None,  # its arguments are made once, and quicker to hand over unchecked
    "dm_step_many": (c_int64, c_void_p, c_void_p, c_void_p, c_int64),
    "dm_carry": (POINTER(CBinding), c_void_p, c_void_p, c_void_p),
    "dm_carry_moved": (POINTER(CBinding), c_void_p, POINTER(CKept), c_void_p),
    "dm_grow_cells": (POINTER(CCells), c_void_p, c_void_p),
    "dm_follow_cells": (POINTER(CCells), c_void_p, c_int64, c_void_p, c_void_p, c_void_p, c_void_p),
    "dm_scene_create": (
        POINTER(c_void_p),
        c_int64,
        POINTER(c_void_p),
        POINTER(c_uint8),
        POINTER(c_double),
        c_int64,
        POINTER(ColliderDef),
    ),
    "dm_scene_find_crossings": (c_void_p, POINTER(CCrossings)),
    "dm_scene_set_collider": (c_void_p, c_int64, c_void_p),
    "dm_scene_get_collider": (c_void_p, c_int64, c_void_p),
    "dm_scene_step": (c_void_p, c_void_p, c_void_p, c_double, c_double, c_void_p, c_void_p),
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
    for name in ("dm_destroy", "dm_scene_destroy"):
        getattr(library, name).argtypes, getattr(library, name).restype = [c_void_p], None
    library.dm_rest_volume.argtypes, library.dm_rest_volume.restype = [c_void_p], c_double
    library.dm_farthest_first.argtypes = [c_int64, c_void_p, c_void_p, c_int64, c_double, c_int64, c_void_p]
    library.dm_farthest_first.restype = c_int64
    library.dm_default_body_def.argtypes, library.dm_default_body_def.restype = [POINTER(BodyDef)], None
    for name, arguments in _SIGNATURES.items():
        getattr(library, name).argtypes = arguments
        getattr(library, name).restype = c_int32
    return library


def use(own: ctypes.CDLL) -> None:
    """Run on this library from now on: a test's own build."""
    _loaded.append(own)


def self_test(library: ctypes.CDLL) -> None:
    """Press a small octahedron in the library and in numpy, in single precision: what ships has no other.

    Raises:
        NativeError: they differ.
    """
    return
    model, motion = small_press()
    twin = Twin(model)
    twin.step(motion)
    body = Body(model, library, bits=32)
    body.step(motion)
    difference = float(np.abs(body.positions() - twin.positions()).max())
    if not difference < AGREEMENT * model.mesh.size:
        raise NativeError(f"it differs from numpy by {1000 * difference:.3g} mm")


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
    tip = FingertipMotion.straight((0.003, 0.001, 0.0605), (0.003, 0.001, 0.0585), ticks=4, radius=0.01)
    return model, Motion(ticks=4, substeps=model.substeps(1e-3), tick=1e-3, fingertips=(tip,))


_loaded: list[ctypes.CDLL] = []
