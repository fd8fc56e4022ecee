"""The surface of a body at rest: the quantities that depend on its shape only, not on the material.

A broken mesh is repaired for the simulation only (vertices are welded, normals recalculated), and `Mesh.notes` says
what was repaired. If that is not possible, `DimpleError` says why and what to do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from trimesh.triangles import area

from ..base import LARGEST, Bools, DimpleError, Floats, Ints, mean_of_pairs, row_parts, sums_at, sums_of_three
from ..constants import ROUNDING
from ..message import Message
from .edges import Edges, edges_of
from .repair import connected, consistent_winding, inward_parts, weld
from .rings import Rings, ordered_rings

LEAST_VOLUME_OPEN = 1e-2  # of size times area: an open mesh below this is a sheet; a hemisphere has 0.17
# largest cotangent weight of an edge: a larger one, of slivers, would shorten the time step and add no accuracy. its
# inverse is the smallest factor that compensates blunt triangles round a vertex
STEEPEST = 4.0


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A welded triangle surface at rest.

    rest_positions: (n, 3) [m].
    triangles: (t, 3), wound so that they face outward.
    triangle_material: (t,) material index.
    triangle_areas: (t,) [m2].
    triangle_springs: (t, 3) the edge from each corner to the next.
    springs: (m, 2) vertices of every edge, sorted by (first, second), first < second.
    rest_lengths: (m,) [m].
    spring_areas: (m,) area of the triangles at the edge [m2].
    spring_triangles: (m, 2) two triangles at the edge; the same one twice on a border.
    vertex_areas: (n,) a third of the area of the triangles round the vertex [m2].
    rings: ordered one-rings.
    cap_edges: (c, 2) border edges.
    cap_loop: (c,) the hole of each border edge.
    volume: enclosed volume, caps included [m3].
    size: longest side of the bounding box [m].
    closed: whether the surface is watertight.
    pressurable: whether it encloses a volume.
    loose: (n,) whether the vertex is in no triangle.
    source: (N,) the vertex that each input vertex became.
    notes: sentences on the repairs.
    """

    rest_positions: Floats
    triangles: Ints
    triangle_material: Ints
    triangle_areas: Floats
    triangle_springs: Ints
    springs: Ints
    rest_lengths: Floats
    spring_areas: Floats
    spring_triangles: Ints
    vertex_areas: Floats
    rings: Rings
    cap_edges: Ints
    cap_loop: Ints
    volume: float
    size: float
    closed: bool
    pressurable: bool
    loose: Bools
    source: Ints
    notes: tuple[str, ...]

    @cached_property
    def cotangents(self) -> Floats:
        """Return the cotangent weight w (m,) of every edge: half the sum of the cotangents of the angles opposite it.

        The sum over edges of w |u_i - u_j|^2 is the integral of |grad u|^2. Where blunt angles would make w negative it
        is set to 0, so that no energy is negative; the weights round such an edge are reduced to compensate, or a
        surface of blunt triangles would be stiffer than its area implies.
        """
        n, ends, square = len(self.rest_positions), self.springs, self.rest_lengths**2
        cotangents = np.empty((len(self.triangles), 3))
        for part in row_parts(len(cotangents)):  # the law of cosines: 4 A cot = b^2 + c^2 - a^2
            sides = square[self.triangle_springs[part]]
            area = np.maximum(2 * self.triangle_areas[part], 1e-12 * self.size**2)
            cotangents[part] = (sums_of_three(sides)[:, None] / 2 - sides) / area[:, None]
        total = sums_at(self.triangle_springs.ravel(), cotangents.ravel(), len(ends)) / 2
        weights = np.clip(total, 0, STEEPEST)
        wanted, kept = (sums_at(ends.ravel(), np.repeat(w * square, 2), n) for w in (total, weights))
        return weights * mean_of_pairs(np.clip(wanted / np.maximum(kept, 1e-30), 1 / STEEPEST, 1.0), ends)


def mesh_from_triangles(positions: Floats, triangles: Ints, *, triangle_material: Ints | None = None) -> Mesh:
    """Build a mesh from triangles.

    Args:
        positions: (N, 3) [m].
        triangles: (t, 3) indices into positions.
        triangle_material: (t,) material index, 0 for all by default.

    Raises:
        DimpleError: no faces, NaN or infinite coordinates, indices out of range, or no area.
    """
    positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    material = np.zeros(len(triangles), np.int64) if triangle_material is None else np.asarray(triangle_material)
    _check(positions, triangles, material)
    notes: list[str] = []

    size = float(np.ptp(positions[~_loose(triangles, len(positions))], axis=0).max())
    if size <= 0:
        raise DimpleError("All vertices are at the same point, so there is no surface to press. Move them apart.")
    kept, source = weld(positions, ROUNDING * size)
    if len(kept) < len(positions):
        notes.append(
            Message("{vertices} vertices coincide with others and move with them.", vertices=len(positions) - len(kept))
        )
        positions, triangles = positions[kept], source[triangles]

    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    triangles, material = triangles[whole], material[whole]
    if not len(triangles):
        raise DimpleError(
            "Every face has shrunk to a line or a point. Dissolve the degenerate geometry or scale it up."
        )
    areas = np.concatenate([area(positions[triangles[part]]) for part in row_parts(len(triangles))])
    if areas.sum() <= (1e-6 * size) ** 2:
        raise DimpleError("The faces have no area. Dissolve the degenerate geometry first.")
    flat = int((areas < 1e-10 * size * size).sum()) + int((~whole).sum())
    if flat:
        notes.append(Message("{flat} faces have no area and add no stiffness.", flat=flat))

    flipped, edges = np.zeros(len(triangles), bool), edges_of(triangles)
    if not edges.consistent:
        consistent = consistent_winding(triangles, edges)
        flipped = (consistent != triangles).any(axis=1)
        notes.append(Message(
            "{flipped} faces were flipped to match the normals of their neighbors.", flipped=int(flipped.sum())
        ))  # fmt: skip
        triangles, edges = consistent, edges_of(consistent)
    border, cap_loop, volume = _closed(positions, triangles, edges)
    least = (LEAST_VOLUME_OPEN if len(border) else ROUNDING) * size * float(areas.sum())
    if volume < -least:
        triangles, border, volume = triangles[:, ::-1].copy(), border[:, ::-1].copy(), -volume
        edges = edges_of(triangles)
        notes.append("The normals pointed inward and were recalculated for the simulation.")
    inward = inward_parts(positions, triangles, edges.adjacency, flipped, volume)
    if inward.any():
        triangles[inward] = triangles[inward][:, ::-1]
        edges = edges_of(triangles)
        border, cap_loop, volume = _closed(positions, triangles, edges)
        notes.append(Message(
            "{inward} faces of separate parts pointed inward and were flipped for the simulation.",
            inward=int(inward.sum())
        ))  # fmt: skip
    pressurable = volume > least
    if not pressurable:
        notes.append("The mesh is an open sheet without a volume, so its fill has no effect.")
    elif len(border):
        notes.append(Message("Holes closed for the pressure only: {holes}.", holes=int(cap_loop.max()) + 1))

    springs, beside = edges.ends, edges.count > 2
    if beside.any():
        notes.append(
            Message("{beside} edges are non-manifold: they join three or more faces.", beside=int(beside.sum()))
        )
    loose = _loose(triangles, len(positions))
    if loose.any():
        notes.append(
            Message("{loose} loose vertices belong to no face and stay where they are.", loose=int(loose.sum()))
        )
    lengths = np.concatenate([_lengths(positions, springs[part]) for part in row_parts(len(springs))])
    vertex_areas = sums_at(triangles.ravel(), np.repeat(areas / 3, 3), len(positions))
    return Mesh(
        rest_positions=positions, triangles=triangles, triangle_material=material, triangle_areas=areas,
        triangle_springs=edges.of_half.reshape(-1, 3), springs=springs, rest_lengths=lengths,
        spring_areas=sums_at(edges.of_half, np.repeat(areas, 3), len(springs)), spring_triangles=edges.faces,
        vertex_areas=vertex_areas, rings=ordered_rings(triangles, edges, len(positions)),
        cap_edges=border, cap_loop=cap_loop, volume=volume, size=size, closed=not len(border), pressurable=pressurable,
        loose=loose, source=source, notes=tuple(notes),
    )  # fmt: skip


def base_vertices(mesh: Mesh) -> Bools:
    """Return which input vertices (N,) are the base of a body: the lowest tenth of its height, or a sheet's rim."""
    height, used = mesh.rest_positions[:, 2], ~mesh.loose
    low, span = height[used].min(), np.ptp(height[used])
    if mesh.pressurable and span > 1e-3 * mesh.size:
        base = height <= low + 0.1 * span
    else:
        base = np.zeros(len(height), bool)
        base[mesh.cap_edges] = True
    return base[mesh.source]


def input_vertices(mesh: Mesh) -> Ints:
    """Return, for every vertex (n,) of a welded mesh, the first input vertex that was merged into it."""
    first: Ints = np.unique(mesh.source, return_index=True)[1]
    return first


def spans_a_plane(points: Floats, size: float) -> bool:
    """Return whether points (n, 3) [m] span more than a line, relative to the size [m] of their body."""
    if len(points) < 3:
        return False
    return bool(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] > 1e-3 * size)


def _check(positions: Floats, triangles: Ints, material: Ints) -> None:
    if not len(positions) or not len(triangles):
        raise DimpleError("The mesh has no faces, so there is no surface to press. Add faces first.")
    if triangles.min() < 0 or triangles.max() >= len(positions):
        raise DimpleError("A face refers to a vertex that does not exist. Run Mesh > Clean Up, or rebuild the mesh.")
    if len(material) != len(triangles):
        raise DimpleError("There must be one material index for each triangle.")
    possible = np.abs(positions) < LARGEST
    if not possible.all():
        bad = np.flatnonzero(~possible.all(axis=1))
        raise DimpleError(
            "Vertex {vertex} has a NaN or infinite coordinate, or one beyond {farthest:g} m ({count} such vertices). "
            "Delete or move them.",
            vertex=bad[0], farthest=LARGEST, count=len(bad)
        )  # fmt: skip


def _lengths(positions: Floats, pairs: Ints) -> Floats:
    return np.sqrt(sums_of_three((positions[pairs[:, 0]] - positions[pairs[:, 1]]) ** 2))


def _loose(triangles: Ints, n: int) -> Bools:
    """Return which of n vertices belong to no face."""
    loose = np.ones(n, bool)
    loose[triangles] = False
    return loose


def _loops(border: Ints, n: int) -> Ints:
    """Return the hole (c,) of each border edge: edges joined by a vertex belong to one hole."""
    return np.unique(connected(border, n)[border[:, 0]], return_inverse=True)[1]


def cap_centres(positions: Floats, cap_edges: Ints, cap_loop: Ints) -> tuple[Floats, Floats]:
    """Return the mean of the border vertices of each hole (h, 3) [m], and its number of edges (h,)."""
    count = np.bincount(cap_loop).astype(float)
    centre = np.stack([sums_at(cap_loop, positions[cap_edges[:, 0], c], len(count)) for c in range(3)], axis=1)
    return centre / count[:, None], count


def capped(mesh: Mesh) -> tuple[Floats, Ints]:
    """Return positions and triangles with the holes closed by fans about the middle of each border."""
    x = mesh.rest_positions
    middles, _ = cap_centres(x, mesh.cap_edges, mesh.cap_loop)
    fans = np.column_stack([mesh.cap_edges, len(x) + mesh.cap_loop])
    return np.concatenate([x, middles]), np.concatenate([mesh.triangles, fans])


def _closed(positions: Floats, triangles: Ints, edges: Edges) -> tuple[Ints, Ints, float]:
    """Return the cap edges (c, 2), the hole of each (c,) and the enclosed volume [m3]."""
    border = edges.border
    cap_loop = _loops(border, len(positions))
    x = positions - positions[triangles].mean(axis=(0, 1))
    parts = [np.linalg.det(x[triangles[part]]) for part in row_parts(len(triangles))]
    total = float(np.concatenate(parts).sum())
    if len(border):
        centre, _ = cap_centres(x, border, cap_loop)
        total += float(np.linalg.det(np.stack([x[border[:, 0]], x[border[:, 1]], centre[cap_loop]], axis=1)).sum())
    return border, cap_loop, total / 6
