"""Cells on a surface: seeds spread over it, the part of it that is nearest to each, and the triangles between them.

Everything goes by distance in the space of place and normal, so that the two sides of a thin part are far apart.
"""

from __future__ import annotations

import numpy as np

from .. import native
from ..base import Bools, Floats, Ints, distinct, row_parts, sums_at, sums_of_three
from ..constants import CREASE
from ..mesh.surface import Mesh

CREASED = 0.3  # of the vertices: where more lie on creases, these are the roughness of a scan
BESIDE = 0.75  # of the spacing: how near to each other seeds may lie on a crease
MANY = 40_000  # vertices that are looked at of a finer mesh, every second, third...: it is smooth between them


def vertex_normals(triangles: Ints, x: Floats) -> Floats:
    """Return unit normals (n, 3), 0 where there is none.

    trimesh's `mean_vertex_normals` needs scipy, which Blender has not, and is 15 times slower without.
    """
    total = np.stack([sums_at(triangles.ravel(), np.repeat(f, 3), len(x)) for f in _face_vectors(triangles, x)], axis=1)
    return total / np.maximum(np.sqrt(sums_of_three(total**2)), 1e-30)[:, None]


def _face_vectors(triangles: Ints, x: Floats) -> Floats:
    """Return the normals (3, t) of faces, as long as twice their area."""
    columns, vectors = np.ascontiguousarray(x.T), np.empty((3, len(triangles)))
    for part in row_parts(len(triangles)):
        first, along, across = (columns.take(at, axis=1) for at in triangles[part].T)
        along -= first
        across -= first
        for c in range(3):
            vectors[c, part] = along[c - 2] * across[c - 1] - along[c - 1] * across[c - 2]
    return vectors


def spread_seeds(mesh: Mesh, place: Floats, used: Ints, count: int, spacing: float) -> Ints:
    """Choose seeds farthest first: on creases and borders to their spacing [m], then all over."""
    creased = np.intersect1d(_creased(mesh), used)
    if len(creased) > CREASED * len(used):
        creased = creased[:0]
    seeds, offered = np.zeros(0, np.int64), used[:: -(-len(used) // MANY)]
    for pool, least in ((creased, BESIDE * spacing), (offered, 0.0)):
        points = place[pool]
        if len(pool) and not len(seeds):  # the first is the point farthest from the middle
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
    """Return the seed (n,) each vertex belongs to: the nearest one of those that its neighbours belong to.

    A cell is in one piece: islands that another cell cut off go to what is round them.
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
    """Give what another cell cut off from its seed to the nearest cell beside it, in place."""
    i, j = np.concatenate([ends, ends[:, ::-1]]).T
    while len(beside := np.flatnonzero(joined[i] & ~joined[j])):
        end, offered = j[beside], cells[i[beside]]
        distance = ((place[end] - place[seeds[offered]]) ** 2).sum(axis=1)
        order = np.lexsort((distance, end))
        end, first = np.unique(end[order], return_index=True)
        cells[end] = offered[order][first]
        joined[end] = True


def dual(corners: Ints) -> Ints:
    """Return the triangles (t, 3) of cells that meet in a fine triangle; two that look opposite ways are none."""
    a, b, c = corners.T
    meet = corners[(a != b) & (b != c) & (c != a)]
    low = meet.argmin(axis=1)
    turned = np.take_along_axis(meet, (low[:, None] + np.arange(3)) % 3, axis=1)
    m = int(corners.max(initial=0)) + 1  # m^3 fits for two million cells
    ways = distinct((turned @ [m * m, m, 1]).astype(np.int64))
    first, rest = np.divmod(ways, m * m)
    second, third = np.divmod(rest, m)
    alone = ~np.isin((first * m + third) * m + second, ways)
    return np.stack([first, second, third], axis=1)[alone]
