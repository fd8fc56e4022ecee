"""A model in the layout of the library: the structures dm_body_def and dm_constants of dimple.h, field by field."""

from __future__ import annotations

import ctypes
from ctypes import Structure, byref, c_double, c_int32, c_int64, c_void_p
from typing import Any

import numpy as np

from ..body.model import Model

_TYPES: dict[str, Any] = {"p": c_void_p, "n": c_int64, "i": c_int32, "d": c_double}


def fields(**kinds: str) -> list[tuple[str, Any]]:
    """Return the fields of a structure by type codes: p array, n int64, i int32, d double, d3 three doubles..."""
    return [(name, _TYPES[kind[0]] * int(kind[1:]) if kind[1:] else _TYPES[kind]) for name, kind in kinds.items()]


class Constants(Structure):
    """The numbers of a body that may change while it lives: dm_constants."""

    _fields_ = fields(
        stiffness="p", damping="p", tension="p", mass="p", inverse_mass="p", friction="p", compliance="p",
        k1="p", k2="p", d0="p", drag="p",
        laws="p", materials="n", painted="p", gravity="d3", ground="d", rest_pressure="d",
        fill_momentum="d9", fill="i", free="i",
        rigged="i",
    )  # fmt: skip


class BodyDef(Structure):
    """The definition of a body: dm_body_def."""

    _fields_ = fields(
        vertices="n", rest="p", loose="p", width="n", ring="p", ring_spring="p", springs="n", ends="p",
        rest_length="p", irregular="n", irregular_spring="p", irregular_end="p", triangles="n", corners="p",
        fans="n", fan="p", cap_edges="n", cap_edge="p", cap_hole="p", rest_volume="d", rest_area="d", size="d",
        surface_vertices="n", surface_rest="p", surface_triangles="n", surface_corners="p", surface_material="p",
    ) + [("constants", Constants)]  # fmt: skip


class Arrays:
    """Keep arrays alive, contiguous and of the right type, while the library reads them."""

    def __init__(self) -> None:
        self._kept: list[Any] = []

    def __enter__(self) -> Arrays:
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


def define(library: ctypes.CDLL, model: Model, surface: Model, arrays: Arrays) -> BodyDef:
    """Return the definition of a body by its model, and by the one from whose surface depths are measured."""
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
        "constants": constants(model, surface, arrays),
    }  # fmt: skip
    for name, value in values.items():
        setattr(definition, name, value)
    return definition


def constants(model: Model, surface: Model, arrays: Arrays) -> Constants:
    """Return the numbers of a model that may change while its body lives."""
    matching = model.matching
    return Constants(
        stiffness=arrays.double(model.springs.stiffness), damping=arrays.double(model.springs.damping),
        tension=arrays.double(matching.tension), mass=arrays.double(matching.mass),
        inverse_mass=arrays.double(model.inverse_mass),
        friction=arrays.double(model.friction), compliance=arrays.double(model.compliance),
        k1=arrays.double(matching.k1), k2=arrays.double(matching.k2), d0=arrays.double(matching.d0),
        drag=arrays.double(matching.damping),
        laws=arrays.double(surface.laws), materials=len(surface.materials),
        painted=arrays.double(surface.maps and np.column_stack([surface.maps.stiffer, surface.maps.deeper])),
        gravity=(c_double * 3)(*model.gravity), ground=-np.inf if model.ground is None else model.ground,
        fill=model.pressure.kind, free=model.free,
        rigged=model.rigged, rest_pressure=model.pressure.rest_pressure,
        fill_momentum=(c_double * 9)(*model.fill_momentum.ravel()),
    )  # fmt: skip
