"""A proxy: a coarser body that is simulated in place of a fine mesh, and the binding that moves the fine surface.

Seeds are spread over the surface. Each fine vertex belongs to the cell of one seed, and where three cells meet the
proxy has a triangle. The mass and the shape-matching stiffness of a cell go to its seed, so their sums are conserved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import native
from ..base import DimpleError, Floats, Ints, Singles, mean_of_pairs, sums_at
from ..body.maps import stiffness_of
from ..body.model import Model, assemble
from ..body.springs import membrane_stiffness
from ..constants import OFFSET
from ..mesh.surface import Mesh, mesh_from_triangles
from ..native import Binding
from .binding import WHOLE, bind
from .cells import dual, grow_cells, spread_seeds, vertex_normals

SMALLEST = 60  # [vertices] fewer no longer have the shape of the body
KEPT = 3  # proxies, one for each of a few bodies that are edited in turn; each takes some megabytes
VOLUME_SLACK = 0.15  # share of the volume: a proxy that is off by more is another body


@dataclass(frozen=True, kw_only=True)
class Proxy:
    """A coarse model and the binding of a fine mesh to it.

    mesh: the fine mesh, n vertices.
    model: the coarse body that is simulated, m vertices.
    seeds: (m,) the vertex of the fine mesh at which each coarse vertex lies.
    cells: (n,) the coarse vertex that takes the mass and stiffness of each vertex of the fine mesh.
    painted: (n,) relative stiffness of each vertex of the fine mesh when the cells were made, see `painted`.
    still: the vertices of the fine mesh that are pinned or loose.
    spacing: mean distance between seeds [m].
    binding: the binding by which the fine mesh follows.
    """

    mesh: Mesh
    model: Model
    seeds: Ints
    cells: Ints
    painted: Singles
    still: Ints
    spacing: float
    binding: Binding

    @cached_property
    def offset(self) -> float:
        """Return the contact offset [m] of the proxy at which its fine mesh keeps the offset of its own edges.

        With the offset of its long edges, a proxy would make contact before the fine mesh does. On average the fine
        mesh stands out from the proxy by the volume between them divided by the area.
        """
        mesh, coarse = self.mesh, self.model.mesh
        out = (mesh.volume - coarse.volume) / float(coarse.triangle_areas.sum())
        return min(OFFSET * float(mesh.rest_lengths.mean()) + max(out, 0.0), OFFSET * self.spacing)


_made: list[Proxy] = []  # the latest proxies, newest first: one for each body that is pressed at a time


def proxy_of(model: Model, vertices: int) -> Proxy:
    """Return a proxy of about the given number of vertices; a kept one of an equal mesh and stiffness is reused.

    Raises:
        DimpleError: it cannot be made; the message says why.
    """
    mesh, stiffer = model.mesh, painted(model)
    spacing = mean_spacing(mesh, vertices)
    for old in [*_made]:
        if old.spacing == spacing and np.array_equal(old.painted, stiffer) and _are_alike(old.mesh, mesh):
            return with_constants(old, model)
    del _made[KEPT - 1 :]
    _made.insert(0, build_proxy(model, vertices))
    return _made[0]


def _are_alike(mesh: Mesh, other: Mesh) -> bool:
    pairs = (mesh.rest_positions, other.rest_positions), (mesh.triangles, other.triangles)
    return mesh is other or all(np.array_equal(*pair) for pair in pairs)


def build_proxy(model: Model, vertices: int) -> Proxy:
    """Make a proxy of about the given number of vertices.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    mesh = model.mesh
    used = np.flatnonzero(~mesh.loose)
    most = most_of(model)
    if not SMALLEST <= vertices <= most:
        raise DimpleError(
            "a proxy of this mesh has from {least} to {most} vertices, not {vertices}.",
            least=SMALLEST, most=most, vertices=vertices
        )  # fmt: skip
    spacing, stiffer = mean_spacing(mesh, vertices), painted(model)
    place = _places(mesh, stiffer, spacing)
    seeds, cells = _seeds_and_cells(mesh, place, spread_seeds(mesh, place, used, vertices, spacing))
    coarse = _constants(model, _coarse_mesh(mesh, seeds, cells), cells)
    return Proxy(
        mesh=mesh, model=coarse, seeds=seeds, cells=cells, painted=stiffer,
        still=np.flatnonzero(model.pinned | mesh.loose), spacing=spacing,
        binding=bind(mesh.rest_positions, coarse.mesh, place, seeds, cells),
    )  # fmt: skip


def _places(mesh: Mesh, stiffer: Singles, spacing: float) -> Floats:
    """Return the vertices (n, 6) [m] in the space of the cells: position, then an offset by normal and stiffness."""
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    # opposite normals put two points one spacing apart; stiffness shifts along a diagonal, an arbitrary direction
    shift = spacing / 2 * normals + spacing / math.sqrt(3) * stiffer[:, None]
    return np.concatenate([mesh.rest_positions, shift], axis=1)


def _seeds_and_cells(mesh: Mesh, place: Floats, seeds: Ints) -> tuple[Ints, Ints]:
    """Return the seeds (m,) whose cells are corners of triangles, and the cells (n,)."""
    for _ in range(3):
        cells = grow_cells(mesh, place, seeds)
        stands = np.zeros(len(seeds), bool)
        stands[dual(cells[mesh.triangles])] = True
        if stands.all():
            return seeds, cells
        seeds = seeds[stands]  # a part too small for a triangle joins others
        if not len(seeds):
            break
    raise DimpleError("its pieces are too small for a proxy.")


def painted(model: Model) -> Singles:
    """Return the stiffness per area of each vertex (n,) relative to the median: 1 for the ratio of the extremes that
    can be painted, which counts as one spacing of distance, and -1 for its inverse.

    Cells do not cross a change of it, so that even a soft spot the size of a fingertip keeps its own vertices.
    """
    known = ~model.mesh.loose
    stiffness = model.matching.k1[known] / np.maximum(model.mesh.vertex_areas[known], 1e-30)
    powers = np.log(np.maximum(stiffness, 1e-30)) / math.log(stiffness_of(0.0) / stiffness_of(1.0))
    found = np.zeros(len(known), np.float32)
    found[known] = np.clip(np.round(powers - np.median(powers), 2), -1, 1)  # equal to the bit if alike
    return found


def with_constants(proxy: Proxy, model: Model) -> Proxy:
    """Return a proxy with the same coarse mesh, but the constants of another model of the same fine mesh.

    Raises:
        DimpleError: the pins of that model need another proxy.
    """
    coarse = _constants(model, proxy.model.mesh, proxy.cells)
    return replace(proxy, model=coarse, still=np.flatnonzero(model.pinned | model.mesh.loose))


def mean_spacing(mesh: Mesh, vertices: float) -> float:
    """Return the distance [m] between vertices if the given number is spread evenly over a surface."""
    return float(np.sqrt(2 / np.sqrt(3) * mesh.triangle_areas.sum() / vertices))


def most_of(model: Model) -> int:
    """Return the largest number of vertices that a proxy may have; a binding numbers them with 16 bits."""
    return min(int((~model.mesh.loose).sum()) // 2, WHOLE)


def _coarse_mesh(fine: Mesh, seeds: Ints, cells: Ints) -> Mesh:
    points = fine.rest_positions[seeds]
    mesh = mesh_from_triangles(points, native.flip_edges(native.library(), points, dual(cells[fine.triangles])))
    if len(mesh.rest_positions) != len(seeds) or mesh.loose.any():
        raise DimpleError("its surface is too crumpled for a proxy of this size.")
    if mesh.pressurable != fine.pressurable or (fine.closed and not mesh.closed):
        raise DimpleError("a proxy of this size would have holes.")
    if fine.pressurable and not abs(mesh.volume / fine.volume - 1) < VOLUME_SLACK:
        raise DimpleError("a proxy of this size would lose too much of the volume.")
    return mesh


def _constants(model: Model, mesh: Mesh, cells: Ints) -> Model:
    """Return the model of a proxy on its mesh."""
    fine, m = model.mesh, len(mesh.rest_positions)
    whole = ~fine.loose

    def total(values: Floats) -> Floats:
        return sums_at(cells[whole], values[whole], m)

    area = np.maximum(total(fine.vertex_areas), 1e-30)

    def mean(values: Floats) -> Floats:
        return total(values * fine.vertex_areas) / area

    matching = model.matching
    pinned = mean(model.pinned.astype(float)) >= 0.5
    damping = matching.damping / np.maximum(2 * np.sqrt(matching.k1 * model.mass), 1e-30)
    ends = cells[fine.springs].ravel()

    def of_surface(values: Floats, unit: Floats) -> Floats:
        """Return a constant of the material [N/m] on the edges of the proxy, averaged from the edges of the fine mesh.

        Args:
            values: (e,) its value on each edge of the fine mesh [N/m].
            unit: (e,) these values for a constant of 1.
        """
        weight = np.where(unit > 0, fine.spring_areas, 0.0)
        sums = sums_at(ends, np.repeat(values / np.maximum(unit, 1e-30) * weight, 2), m)
        return mean_of_pairs(sums / np.maximum(sums_at(ends, np.repeat(weight, 2), m), 1e-30), mesh.springs)

    k = of_surface(model.springs.stiffness, membrane_stiffness(fine, np.ones(len(fine.springs))))
    tension = of_surface(matching.tension, fine.cotangents)
    coarse = assemble(
        mesh, model.materials, mass=np.maximum(total(model.mass), 1e-30), pinned=pinned,
        friction=mean(model.friction), compliance=mean(model.compliance * fine.vertex_areas) / area,
        damping=mean(damping),
        stiffness=membrane_stiffness(mesh, k), tension=mesh.cotangents * tension,
        k1=total(matching.k1), k2=total(matching.k2), d0=mean(matching.d0), fill=model.pressure.fill,
        rest_pressure=model.pressure.rest_pressure, gravity=model.gravity, ground=model.ground,
    )  # fmt: skip
    coarse = replace(coarse, rigged=model.rigged)
    if coarse.free != model.free or pinned.all():
        raise DimpleError("its pins are too few for a proxy of this size.")
    return coarse
