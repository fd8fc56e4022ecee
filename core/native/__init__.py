"""The native core: find, load and test its library, or say why there is none here.

The library lies beside this file (a developer's machine) or in the wheel `dimple_native` (an installed extension).
It is used only if its ABI number equals `constants.ABI` and a small body moves correctly in it (`check`).

The C files by subject. Interface: dimple.h, api, scene_door, threads; constants.h has every number. Step: step, slices,
rings, integrate, fill, pose, body_constants, sleep. Fingertips: foot, fingertip, skin_contact, facets, fingertip_reach.
Contact of bodies and props: scene, tree, contact_query, contact_pairs, contact_planes, keep_apart, proximity, gaps,
batch, crossings, islands, touching, props, falling, body_rolling. Proxies: cells, seeds, flips, carriers, carry.
variant.c compiles them for each precision and instruction set.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import platform
import sys
from ctypes import POINTER, c_double, c_int32, c_int64, c_uint8, c_void_p
from pathlib import Path
from typing import Any

from ..body.model import Model
from ..constants import ABI
from ..errors import DimpleError
from ..message import Message
from .body import AVX2 as AVX2
from .body import BASE as BASE
from .body import BEST as BEST
from .body import Body as Body
from .body import NativeError as NativeError
from .body import step_many as step_many
from .carry import Binding as Binding
from .carry import CBinding
from .carry import carry as carry
from .carry import carry_by_nodes as carry_by_nodes
from .cells import CCells
from .cells import farthest_first as farthest_first
from .cells import follow_cells as follow_cells
from .cells import grow_cells as grow_cells
from .definition import BodyDef, Constants
from .first_use import check
from .flips import flip_edges as flip_edges
from .scene import CCrossings, ColliderDef
from .scene import Scene as Scene

LIBRARY = {"win32": "dimple_core.dll", "darwin": "libdimple_core.dylib"}.get(sys.platform, "libdimple_core.so")
BITS = {"native": 32, "native64": 64}  # precision of the state, by backend

_SIGNATURES: dict[str, tuple[Any, ...] | None] = {  # fmt: skip
    "dm_create": (POINTER(c_void_p), POINTER(BodyDef), c_int32, c_int32),
    "dm_set_constants": (c_void_p, POINTER(Constants)),
    "dm_set_rest": (c_void_p, c_void_p, c_void_p, c_void_p, c_void_p),
    "dm_wake_body": (c_void_p,),
    "dm_set_state": (c_void_p, c_void_p, c_void_p),
    "dm_get_state": (c_void_p, c_void_p, c_void_p),
    "dm_step": None,  # its arguments are made once, and passed faster unchecked
    "dm_step_many": (c_int64, c_void_p, c_void_p, c_void_p),
    "dm_get_law": (c_void_p, c_int64, c_void_p, c_double, c_int64, c_void_p, c_void_p),
    "dm_carry": (POINTER(CBinding), c_void_p, c_void_p, c_void_p),
    "dm_carry_by_nodes": (c_int64, c_int64, c_void_p, c_void_p, c_void_p, c_void_p),
    "dm_grow_cells": (POINTER(CCells), c_void_p, c_void_p),
    "dm_follow_cells": (POINTER(CCells), c_void_p, c_int64, c_void_p, c_void_p, c_void_p, c_void_p),
    "dm_flip_edges": (c_int64, c_void_p, c_int64, c_void_p),
    "dm_scene_create": (
        POINTER(c_void_p),
        c_int64,
        POINTER(c_void_p),
        POINTER(c_uint8),
        POINTER(c_double),
        c_int64,
        POINTER(ColliderDef),
        POINTER(CCrossings),
    ),
    "dm_scene_find_crossings": (c_void_p, POINTER(CCrossings)),
    "dm_scene_set_collider": (c_void_p, c_int64, c_void_p),
    "dm_scene_get_collider": (c_void_p, c_int64, c_void_p),
    "dm_scene_step": (c_void_p, c_void_p, c_void_p, c_double, c_double, c_void_p, c_void_p, c_void_p, c_void_p),
}


def places() -> list[Path]:
    """Return the paths where the library may be, in order of preference."""
    wheel = importlib.util.find_spec("dimple_native")
    folders = [Path(__file__).parent, *map(Path, (wheel and wheel.submodule_search_locations) or ())]
    return [folder / LIBRARY for folder in folders]


def library() -> ctypes.CDLL:
    """Return the library in use; the first call loads and tests it.

    Raises:
        DimpleError: no library runs here; the message says what to do.
    """
    if not _loaded:
        _loaded.append(_tested())
    return _loaded[-1]


def _tested() -> ctypes.CDLL:
    here = f"{platform.system()} {platform.machine()}"
    found = next((path for path in places() if path.exists()), None)
    if found is None:
        raise DimpleError(
            "This installation has no compiled core for {here}. Install the zip of Dimple for that platform.", here=here
        )
    try:
        library = load(found)
        check(library)
    except (OSError, AttributeError, NativeError) as error:
        raise DimpleError(
            "The compiled core for {here} was refused ({error}). Install the zip of Dimple for that platform again.",
            here=here, error=error
        ) from error  # fmt: skip
    return library


def create(
    model: Model, *, surface: Model | None = None, backend: str = "native"
) -> Body:
    """Return a body at rest that owns its state.

    Args:
        surface: model from whose surface at rest the depths of fingertips are measured, if `model` is its proxy.
        backend: "native" (single precision) or "native64".

    Raises:
        DimpleError: no such backend, or no library runs here.
    """
    if backend not in BITS:
        raise DimpleError("There is no backend {backend}: choose native or native64.", backend=backend)
    return Body(model, library(), surface=surface, bits=BITS[backend])


def instructions(instruction_set: int = BEST) -> str:
    """Return the name of an instruction set, "" if this machine lacks it."""
    name: bytes = library().dm_instructions(instruction_set)
    return name.decode()


def load(path: Path) -> ctypes.CDLL:
    """Load a library and check its ABI number.

    Raises:
        OSError: it is damaged or for another machine.  NativeError: its version is another.
    """
    library = ctypes.CDLL(str(path))
    library.dm_abi.restype = c_int32
    if library.dm_abi() != ABI:
        raise NativeError(Message("it has version {version}, not {expected}", version=library.dm_abi(), expected=ABI))
    library.dm_message.restype = library.dm_instructions.restype = ctypes.c_char_p
    for name in ("dm_destroy", "dm_scene_destroy"):
        getattr(library, name).argtypes, getattr(library, name).restype = [c_void_p], None
    library.dm_rest_volume.argtypes, library.dm_rest_volume.restype = [c_void_p], c_double
    library.dm_farthest_first.argtypes = [c_int64, c_void_p, c_int64, c_double, c_int64, c_void_p]
    library.dm_farthest_first.restype = c_int64
    library.dm_set_workers.argtypes, library.dm_set_workers.restype = [c_int64], None
    library.dm_default_body_def.argtypes, library.dm_default_body_def.restype = [POINTER(BodyDef)], None
    for name, arguments in _SIGNATURES.items():
        getattr(library, name).argtypes = arguments
        getattr(library, name).restype = c_int32
    library.dm_set_workers(os.cpu_count() or 1)
    return library


def use_cores(share: float = 1.0) -> None:
    """Use threads on this share of the cores for every step from now on; the results are the same, bit for bit."""
    library().dm_set_workers(max(1, round(share * (os.cpu_count() or 1))))


_loaded: list[ctypes.CDLL] = []
