"""The surface of a body at rest: what its shape alone decides, before any material.

A broken mesh is mended where the artist would not notice (soup is welded, faces are turned to agree) and the
mend is said in `Mesh.notes`; where it cannot be mended `DimpleError` says why and what to do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base import CLOSED_BULK, FARTHEST, OPEN_BULK, WELD_SHARE, Bools, DimpleError, Floats, Ints, sums_at
from .repair import agreeing, connected, inward_parts, weld
from .rings import Rings, ordered_rings


@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh:
    """Hold a welded triangle surface at rest.

    rest_positions: (n, 3) [m].  triangles: (t, 3), turned outward.  triangle_material: (t,) index.
    springs: (m, 2), every edge once.  rest_lengths: (m,) [m].  spring_areas: (m,) area of the triangles beside [m2].
    spring_triangles: (m, 2) two triangles beside (the same twice on a border).  vertex_areas: (n,) a third of the
    triangles round a vertex [m2].  rings: ordered one-rings.  cap_edges: (c, 2) border edges and cap_loop: (c,) the
    hole each closes.  volume: [m3], caps included.  size: longest side of the bounding box [m].
    closed: watertight.  pressurable: has an inside.  loose: (n,) in no triangle.
    source: (N,) vertex of each input vertex.  notes: what was mended, in sentences.
    """

    rest_positions: Floats
    triangles: Ints
    triangle_material: Ints
    triangle_areas: Floats
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


def mesh_from_triangles(positions: Floats, triangles: Ints, *, triangle_material: Ints | None = None) -> Mesh:
    """Build a mesh from triangles.

    Args:
        positions: (N, 3) [m].
        triangles: (t, 3) indices into positions.
        triangle_material: (t,) material index, all 0 when left out.

    Raises:
        DimpleError: no faces, coordinates that are not numbers, indices out of range, no area at all.
    """
    import trimesh

    positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    material = np.zeros(len(triangles), np.int64) if triangle_material is None else np.asarray(triangle_material)
    _check(positions, triangles, material)
    notes: list[str] = []

    size = float(np.ptp(positions[np.unique(triangles)], axis=0).max())
    if size <= 0:
        raise DimpleError("All vertices lie in one point, so there is nothing to press. Give the mesh a size.")
    kept, source = weld(positions, WELD_SHARE * size)
    if len(kept) < len(positions):
        notes.append(f"{len(positions) - len(kept)} vertices lie on others and move with them.")
        positions, triangles = positions[kept], source[triangles]

    whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    triangles, material = triangles[whole], material[whole]
    if not len(triangles):
        raise DimpleError(
            "Every face has shrunk to a line or a point. Dissolve the degenerate geometry or scale it up."
        )
    surface = trimesh.Trimesh(positions, triangles, process=False)
    areas = surface.area_faces
    if areas.sum() <= (1e-6 * size) ** 2:
        raise DimpleError("The faces have no area. Dissolve the degenerate geometry first.")
    flat = int((areas < 1e-10 * size * size).sum()) + int((~whole).sum())
    if flat:
        notes.append(f"{flat} faces have no area and add no stiffness.")

    mended = np.zeros(len(triangles), bool)
    if not surface.is_winding_consistent:
        turned = agreeing(triangles, surface.face_adjacency)
        mended = (turned != triangles).any(axis=1)
        notes.append(f"{int(mended.sum())} faces were turned to agree with their neighbours.")
        triangles = turned
    border, cap_loop, volume = _closed(positions, triangles)
    bulk = (OPEN_BULK if len(border) else CLOSED_BULK) * size * float(areas.sum())
    if volume < -bulk:
        triangles, border, volume = triangles[:, ::-1].copy(), border[:, ::-1].copy(), -volume
        notes.append("The faces looked inward and were turned outward for the simulation.")
    inward = inward_parts(positions, triangles, surface.face_adjacency, mended)
    if inward.any():
        triangles[inward] = triangles[inward][:, ::-1]
        border, cap_loop, volume = _closed(positions, triangles)
        notes.append(f"{int(inward.sum())} faces of separate parts looked inward and were turned outward.")
    pressurable = volume > bulk
    if not pressurable:
        notes.append("The mesh is a sheet without an inside: its fill is off.")
    elif len(border):
        notes.append(f"{int(cap_loop.max()) + 1} holes are closed for the pressure only.")

    springs, spring_triangles, spring_areas, faces_beside = _springs(triangles, areas, len(positions))
    if (faces_beside > 2).any():
        notes.append(f"{int((faces_beside > 2).sum())} edges join three or more faces.")
    loose = np.ones(len(positions), bool)
    loose[triangles] = False
    if loose.any():
        notes.append(f"{int(loose.sum())} loose vertices belong to no face and stay where they are.")
    lengths = np.linalg.norm(positions[springs[:, 0]] - positions[springs[:, 1]], axis=1)
    vertex_areas = sums_at(triangles.ravel(), np.repeat(areas / 3, 3), len(positions))
    return Mesh(
        rest_positions=positions, triangles=triangles, triangle_material=material, triangle_areas=areas,
        springs=springs, rest_lengths=lengths, spring_areas=spring_areas, spring_triangles=spring_triangles,
        vertex_areas=vertex_areas, rings=ordered_rings(triangles, springs, len(positions)),
        cap_edges=border, cap_loop=cap_loop, volume=volume, size=size, closed=not len(border), pressurable=pressurable,
        loose=loose, source=source, notes=tuple(notes),
    )  # fmt: skip


def base_vertices(mesh: Mesh, *, up: Sequence[float] = (0, 0, 1), share: float = 0.1) -> Bools:
    """Return which input vertices (N,) a body stands on: the lowest `share` of its height, or the rim of a sheet."""
    height = mesh.rest_positions @ np.asarray(up, np.float64)
    used = ~mesh.loose
    low, span = height[used].min(), np.ptp(height[used])
    if mesh.pressurable and span > 1e-3 * mesh.size:
        held = height <= low + share * span
    else:
        held = np.zeros(len(height), bool)
        held[mesh.cap_edges] = True
    return held[mesh.source]


def input_vertices(mesh: Mesh) -> Ints:
    """Return, for every vertex (n,) of a welded mesh, the first of the input vertices that it stands for."""
    first: Ints = np.unique(mesh.source, return_index=True)[1]
    return first


def spans_a_plane(points: Floats, size: float) -> bool:
    """Tell whether points (n, 3) [m] are more than a line, beside the size [m] of their body."""
    if len(points) < 3:
        return False
    return bool(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] > 1e-3 * size)


def _check(positions: Floats, triangles: Ints, material: Ints) -> None:
    if not len(positions) or not len(triangles):
        raise DimpleError("The mesh has no faces, so there is no surface to press. Add faces first.")
    if triangles.min() < 0 or triangles.max() >= len(positions):
        raise DimpleError("A face names a vertex that does not exist. Run Mesh > Clean Up, or rebuild the mesh.")
    if len(material) != len(triangles):
        raise DimpleError("There must be one material index for each triangle.")
    bad = np.flatnonzero(~(np.abs(positions) < FARTHEST).all(axis=1))
    if len(bad):
        raise DimpleError(
            f"Vertex {bad[0]} has a coordinate that is not a number, or out of this world ({len(bad)} such vertices). "
            "Delete or move them."
        )


def _border(triangles: Ints, n: int) -> Ints:
    """Return the edges (c, 2) that caps must add so that every edge is walked as often one way as the other.

    The border of any set of oriented faces is made of cycles, so a cone over each part closes even a
    non-manifold mesh: the pressure on it exerts no net force, and a wall inside counts as skin only.
    """
    halves = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    keys, counts = np.unique(halves[:, 0] * n + halves[:, 1], return_counts=True)
    mirrored = keys % n * n + keys // n
    at = np.minimum(np.searchsorted(keys, mirrored), len(keys) - 1)
    back = np.where(keys[at] == mirrored, counts[at], 0)
    missing = np.repeat(mirrored, np.maximum(counts - back, 0))
    return np.stack([missing // n, missing % n], axis=1)


def _loops(border: Ints, n: int) -> Ints:
    """Number the holes: border edges joined by a vertex are of one hole."""
    return np.unique(connected(border, n)[border[:, 0]], return_inverse=True)[1]


def cap_centres(positions: Floats, cap_edges: Ints, cap_loop: Ints) -> tuple[Floats, Floats]:
    """Return the mean of the border vertices of each hole (h, 3), and how many edges the hole has (h,)."""
    count = np.bincount(cap_loop).astype(float)
    centre = np.stack([sums_at(cap_loop, positions[cap_edges[:, 0], c], len(count)) for c in range(3)], axis=1)
    return centre / count[:, None], count


def _closed(positions: Floats, triangles: Ints) -> tuple[Ints, Ints, float]:
    """Return the cap edges (c, 2), the hole each closes (c,) and the volume inside [m3]."""
    border = _border(triangles, len(positions))
    cap_loop = _loops(border, len(positions))
    x = positions - positions[triangles].mean(axis=(0, 1))
    total = float(np.linalg.det(x[triangles]).sum())
    if len(border):
        centre, _ = cap_centres(x, border, cap_loop)
        total += float(np.linalg.det(np.stack([x[border[:, 0]], x[border[:, 1]], centre[cap_loop]], axis=1)).sum())
    return border, cap_loop, total / 6


def _springs(triangles: Ints, areas: Floats, n: int) -> tuple[Ints, Ints, Floats, Ints]:
    halves = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    keys = halves[:, 0] * n + halves[:, 1]
    unique, first, inverse, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    last = np.zeros(len(unique), np.int64)
    last[inverse] = np.arange(len(keys))
    beside = np.stack([first, last], axis=1) % len(triangles)
    return np.stack([unique // n, unique % n], axis=1), beside, sums_at(inverse, np.tile(areas, 3), len(unique)), count
