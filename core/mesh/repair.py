"""The repair of a surface: near vertices are welded, winding is made consistent, closed parts face outward.

trimesh does what it can with numpy alone. What joins pieces (`connected`, `consistent_winding`, parts) is ours: there
trimesh needs scipy or networkx, and Blender has neither.
"""

from __future__ import annotations

from collections import deque
from itertools import product

import numpy as np
from trimesh.grouping import unique_rows

from ..base import Bools, Floats, Ints, sums_at
from ..constants import EXACT
from .edges import edges_of

SLANTED = np.array([0.3517, 0.5843, 0.7313])  # no longer than 1; hardly any two points of a mesh are level along it
LEVEL = 64  # points that may be level, before all are compared the long way


def connected(pairs: Ints, n: int) -> Ints:
    """Return the lowest index (n,) that each of n nodes is connected to by edges `pairs` (m, 2)."""
    label, (first, second) = np.arange(n), pairs.T
    while len(first):
        # the label of a label changes, not that of a node: so none is cut off from what it was joined to
        np.minimum.at(label, np.maximum(first, second), np.minimum(first, second))
        while ((lowest := label.take(label)) != label).any():
            label = lowest
        first, second = label.take(first), label.take(second)
        apart = first != second
        first, second = first[apart], second[apart]
    return label


def weld(positions: Floats, cell: float) -> tuple[Ints, Ints]:
    """Find the vertices to merge: all that are nearer than half a cell [m], none farther than a few cells.

    trimesh's own `merge_vertices` rounds to one grid, and so leaves near vertices apart where a grid line runs between.

    Args:
        positions: (N, 3) [m].
        cell: size of a grid cell [m].

    Returns:
        one vertex of each merged group (n,), and the group of every vertex (N,).
    """
    itself = np.arange(len(positions))
    if _all_apart(positions, cell):
        return itself, itself
    pairs = []
    # near points may lie on two sides of a grid line, but not of both of two grids half a cell apart
    for shift in product((0.0, 0.5), repeat=3):
        first, place = unique_rows(np.floor(positions / cell + shift).astype(np.int64))
        mate = first[place]
        moved = np.flatnonzero(mate != np.arange(len(mate)))
        pairs.append(np.stack([mate[moved], moved], axis=1))
    label = connected(np.concatenate(pairs), len(positions))
    kept, source = np.unique(label, return_inverse=True)
    return kept, source


def _all_apart(positions: Floats, cell: float) -> bool:
    """Tell whether no two points (N, 3) [m] are within a cell [m] along all axes; False where that takes too long.

    Such points are within sqrt(3) cells along any direction.
    """
    along = positions @ SLANTED
    order = np.argsort(along)
    along = along[order]
    level = np.arange(len(order))
    for step in range(1, LEVEL):
        level = level[: np.searchsorted(level, len(order) - step)]
        level = near = level[along.take(level + step) - along.take(level) <= 2 * cell]
        if not len(level):
            return True
        for axis in positions.T:
            near = near[np.abs(axis[order.take(near + step)] - axis[order.take(near)]) <= cell]
        if len(near):
            return False
    return False


def consistent_winding(faces: Ints, adjacency: Ints) -> Ints:
    """Return the faces (t, 3) wound as their neighbours are; most faces of each part keep their winding.

    Args:
        faces: (t, 3).
        adjacency: (a, 2) faces that share an edge.
    """
    neighbours: list[list[int]] = [[] for _ in faces]
    for a, b in adjacency:
        neighbours[a].append(int(b))
        neighbours[b].append(int(a))
    turned, seen = faces.copy(), np.zeros(len(faces), bool)
    for start in range(len(faces)):
        if seen[start]:
            continue
        seen[start], queue, part = True, deque([start]), [start]
        while queue:
            here = queue.popleft()
            edges = {(int(turned[here, c]), int(turned[here, (c + 1) % 3])) for c in range(3)}
            for there in neighbours[here]:
                if not seen[there]:
                    a, b, c = (int(v) for v in turned[there])
                    if edges & {(a, b), (b, c), (c, a)}:
                        turned[there] = (c, b, a)
                    seen[there] = True
                    queue.append(there)
                    part.append(there)
        if 2 * (turned[part] != faces[part]).any(axis=1).sum() > len(part):
            turned[part] = turned[part][:, ::-1]
    return turned


def inward_parts(positions: Floats, faces: Ints, adjacency: Ints, flipped: Bools, volume: float) -> Bools:
    """Return which faces (t,) belong to parts turned inside out; a part facing inward inside another is a cavity.

    Args:
        positions: (n, 3) [m].
        faces: (t, 3) of consistent winding.
        adjacency: (a, 2) faces that share an edge.
        flipped: (t,) was turned over by `consistent_winding`; an open part without such a face is left as it is.
        volume: inside all of it, holes closed [m3].
    """
    inward, lowest = np.zeros(len(faces), bool), connected(adjacency, len(faces))
    if volume >= 0 and not lowest.any():  # one part
        return inward
    names, label = np.unique(lowest, return_inverse=True)
    count, corners = np.bincount(label), positions[faces]
    mean = np.stack([sums_at(label, corners[:, :, c].mean(axis=1), len(names)) / count for c in range(3)], axis=1)
    a, b, c = (corners - mean[label][:, None]).transpose(1, 2, 0)
    own = a * np.cross(b, c, axis=0)
    volumes, terms = (sums_at(label, each.sum(axis=0), len(names)) for each in (own, np.abs(own)))
    for part in np.flatnonzero(volumes < -EXACT * terms):  # flat, it has neither an inside nor an outside
        mine = label == part
        if flipped[mine].any() or not edges_of(faces[mine]).excess.any():
            inward[mine] = not _inside(corners[~mine], corners[mine][0, 0])
    return inward


def _inside(triangles: Floats, point: Floats) -> bool:
    """Return whether triangles (t, 3, 3) wind round a point (3,). Source: van Oosterom and Strackee 1983."""
    r = triangles - point
    length = np.linalg.norm(r, axis=2)
    a, b, c = r[:, 0], r[:, 1], r[:, 2]
    below = length.prod(axis=1) + sum(
        (p * q).sum(axis=1) * length[:, k] for p, q, k in ((a, b, 2), (b, c, 0), (c, a, 1))
    )
    return abs(2 * np.arctan2(np.linalg.det(r), below).sum()) > 2 * np.pi
