"""The constants of all vertices and edges of a mesh, from its materials and painted maps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import Floats, mean_of_pairs, sums_at
from ..constants import ROUNDING
from ..material import Material
from ..mesh.surface import Mesh
from .estimate import SPRINGS, estimate, skin_compliance
from .maps import Maps
from .springs import membrane_stiffness


def constants_on(mesh: Mesh, materials: Sequence[Material], maps: Maps) -> dict[str, Floats]:
    """Return the constants of the laws, as arguments of `model.assemble`.

    Args:
        materials: one for each index in mesh.triangle_material.
    """
    which = mesh.triangle_material
    table = np.array([_row(m, mesh.size) for m in materials]).T
    kappa1, kappa2, d0, tension, damping, friction, yields = table
    k1, k2 = (maps.stiffer * _vertex_sum(mesh, c[which] * mesh.triangle_areas / 3) for c in (kappa1, kappa2))
    at_vertices = _vertex_means(mesh, friction[which], damping[which], d0[which], yields[which])
    stiffer, wider = (mean_of_pairs(f, mesh.springs) for f in (maps.stiffer, maps.wider))
    tension = mean_of_pairs(tension[which], mesh.spring_triangles) * stiffer * wider**2
    return {
        "friction": at_vertices[0], "damping": at_vertices[1],
        "compliance": at_vertices[3] / np.maximum(maps.stiffer * mesh.vertex_areas, 1e-30),
        "stiffness": membrane_stiffness(mesh, SPRINGS * tension),
        "k1": k1, "k2": k2, "d0": at_vertices[2] * maps.deeper,
        "tension": mesh.cotangents * tension,
    }  # fmt: skip


def mass_on(mesh: Mesh, materials: Sequence[Material]) -> Floats:
    """Return the mass of each vertex (n,) [kg].

    A material contributes the mass of a body made of it alone, times its fraction of the area.
    """
    total_area = float(mesh.triangle_areas.sum())
    # a sheet has no volume: assume a thickness of a twentieth of its size
    bulk = mesh.volume if mesh.pressurable else total_area * mesh.size / 20
    whole = np.array([m.mass if m.mass is not None else (m.density or 0.0) * bulk for m in materials])
    mass = _vertex_sum(mesh, whole[mesh.triangle_material] * mesh.triangle_areas / total_area / 3)
    return np.maximum(mass, ROUNDING * mass[~mesh.loose].mean())


def _row(material: Material, size: float) -> tuple[float, ...]:
    constants = estimate(material, size)
    return (*constants, material.damping_ratio, material.friction, skin_compliance(material, constants))


def _vertex_sum(mesh: Mesh, per_triangle: Floats) -> Floats:
    return sums_at(mesh.triangles.ravel(), np.repeat(per_triangle, 3), len(mesh.rest_positions))


def _vertex_means(mesh: Mesh, *per_triangle: Floats) -> list[Floats]:
    count = np.maximum(np.bincount(mesh.triangles.ravel(), minlength=len(mesh.rest_positions)), 1)
    return [_vertex_sum(mesh, values) / count for values in per_triangle]
