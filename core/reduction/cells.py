"""Cells on a surface: the seeds spread over it, the part nearest to each seed, and the triangles between cells.

All distances are in a space of position and normal, in which the two sides of a thin part are far apart.
"""

from __future__ import annotations

import numpy as np

from .. import native
from ..base import Bools, Floats, Ints, distinct, row_parts, sums_at, sums_of_three
from ..constants import CREASE
from ..mesh.surface import Mesh


def vertex_normals(triangles: Ints, x: Floats) -> Floats:
    """Return unit normals (n, 3), 0 for a vertex without one.

    trimesh's `mean_vertex_normals` is 15 times slower without scipy, which Blender does not include.
    """
    total = np.stack([sums_at(triangles.ravel(), np.repeat(f, 3), len(x)) for f in _face_vectors(triangles, x)], axis=1)
    return total / np.maximum(np.sqrt(sums_of_three(total**2)), 1e-30)[:, None]


def _face_vectors(triangles: Ints, x: Floats) -> Floats:
    """Return the normals (3, t) of faces, of twice their area in length."""
    columns, vectors = np.ascontiguousarray(x.T), np.empty((3, len(triangles)))
    for part in row_parts(len(triangles)):
        first, along, across = (columns.take(at, axis=1) for at in triangles[part].T)
        along -= first
        across -= first
        for c in range(3):
            vectors[c, part] = along[c - 2] * across[c - 1] - along[c - 1] * across[c - 2]
    return vectors


def spread_seeds(mesh: Mesh, place: Floats, used: Ints, count: int, spacing: float) -> Ints:
    """Choose seeds by farthest-point sampling: first on creases and borders, then over the whole surface.

    Args:
        place: (n, 6) the vertices in the space of the cells [m].
        used: the vertices that may become seeds.
        count: number of seeds.
        spacing: mean distance between seeds [m].
    """
    seeds = np.zeros(0, np.int64)
    for pool, least in ((np.intersect1d(_creased(mesh), used), spacing), (used, 0.0)):
        points = place[pool]
        if len(pool) and not len(seeds):  # the first seed is the point farthest from the middle
            seeds = pool[[int(((points - points.mean(axis=0)) ** 2).sum(axis=1).argmax())]]
        both = np.concatenate([seeds, pool])
        chosen = native.farthest_first(native.library(), place[both], len(seeds), least**2, count - len(seeds))
        seeds = np.concatenate([seeds, both[chosen]])
    return seeds


def _creased(mesh: Mesh) -> Ints:
    """Return the vertices on creases and borders."""
    normals = _face_vectors(mesh.triangles, mesh.rest_positions)
    normals /= np.maximum(np.sqrt((normals**2).sum(axis=0)), 1e-30)
    first, last = mesh.spring_triangles.T
    sharp = sum(n[first] * n[last] for n in normals) < CREASE
    return np.unique(np.concatenate([mesh.springs[sharp].ravel(), mesh.cap_edges.ravel()]))


def grow_cells(mesh: Mesh, place: Floats, seeds: Ints) -> Ints:
    """Return the seed (n,) of each vertex: the nearest one among the seeds of its neighbours.

    A cell is in one piece: an island that another cell cuts off joins a cell next to it.
    """
    cells, joined = native.grow_cells(native.library(), mesh.springs, place, seeds)
    lost = np.flatnonzero(cells < 0)  # parts without a seed, and loose vertices
    if len(lost) + joined.sum() < len(cells):
        _join_islands(mesh.springs, place, seeds, cells, joined)
    for part in np.array_split(lost, len(lost) * len(seeds) // 2_000_000 + 1):
        distance = ((place[part, None, :3] - place[None, seeds, :3]) ** 2).sum(axis=2)
        cells[part] = distance.argmin(axis=1)
    return cells


def _join_islands(ends: Ints, place: Floats, seeds: Ints, cells: Ints, joined: Bools) -> None:
    """Assign the vertices that another cell cuts off from their seed to the nearest adjacent cell, in place."""
    i, j = np.concatenate([ends, ends[:, ::-1]]).T
    while len(beside := np.flatnonzero(joined[i] & ~joined[j])):
        end, offered = j[beside], cells[i[beside]]
        distance = ((place[end] - place[seeds[offered]]) ** 2).sum(axis=1)
        order = np.lexsort((distance, end))
        end, first = np.unique(end[order], return_index=True)
        cells[end] = offered[order][first]
        joined[end] = True


def dual(corners: Ints) -> Ints:
    """Return the triangles (t, 3) of cells that meet in a fine triangle; those that occur in both windings cancel."""
    a, b, c = corners.T
    meet = corners[(a != b) & (b != c) & (c != a)]
    low = meet.argmin(axis=1)
    turned = np.take_along_axis(meet, (low[:, None] + np.arange(3)) % 3, axis=1)
    m = int(corners.max(initial=0)) + 1  # m^3 fits in 64 bits up to two million cells
    ways = distinct((turned @ [m * m, m, 1]).astype(np.int64))
    first, rest = np.divmod(ways, m * m)
    second, third = np.divmod(rest, m)
    alone = ~np.isin((first * m + third) * m + second, ways)
    return np.stack([first, second, third], axis=1)[alone]
