"""The repair of a surface: coincident vertices are welded, winding is made consistent, closed parts face outward.

trimesh's own functions for this need scipy or networkx, and Blender includes neither.
"""

from __future__ import annotations

import numpy as np

from ..base import Bools, Floats, Ints, sums_at
from ..constants import EXACT
from .edges import Edges, edges_of

SLANTED = np.array([0.3517, 0.5843, 0.7313])  # unit vector: few points of a mesh are level along it


def connected(pairs: Ints, n: int) -> Ints:
    """Return the lowest index (n,) that each of n nodes is connected to by edges `pairs` (m, 2)."""
    label, (first, second) = np.arange(n), pairs.T
    while len(first):
        # change the label of a label, not of a node, so that no node is separated from those it was joined to
        np.minimum.at(label, np.maximum(first, second), np.minimum(first, second))
        while ((lowest := label.take(label)) != label).any():
            label = lowest
        first, second = label.take(first), label.take(second)
        apart = first != second
        first, second = first[apart], second[apart]
    return label


def weld(positions: Floats, cell: float) -> tuple[Ints, Ints]:
    """Find the vertices to merge: pairs closer than half a cell [m] along each axis, and chains of such pairs.

    trimesh's own `merge_vertices` rounds to one grid, and so misses pairs with a grid line in between.

    Args:
        positions: (N, 3) [m].

    Returns:
        one vertex of each merged group (n,), and the group of every vertex (N,).
    """
    along = positions @ SLANTED
    order = np.argsort(along)
    along, left, pairs = along[order], np.arange(len(order)), [np.zeros((0, 2), np.int64)]
    for step in range(1, len(order)):  # close vertices are few places apart in this order
        left = left[: np.searchsorted(left, len(order) - step)]
        left = left[along.take(left + step) - along.take(left) <= cell]
        if not len(left):
            break
        both = np.stack([order.take(left), order.take(left + step)], axis=1)
        apart = np.abs(positions[both[:, 0]] - positions[both[:, 1]]).max(axis=1)
        pairs.append(both[apart < cell / 2])
        left = left[apart > 0]  # a coincident vertex has the same neighbours
    kept, source = np.unique(connected(np.concatenate(pairs), len(positions)), return_inverse=True)
    return kept, source


def consistent_winding(faces: Ints, edges: Edges) -> Ints:
    """Return the faces (t, 3) with consistent winding; most faces of each part keep theirs.

    The graph has two nodes for each face, as it is and flipped, and joins those of neighbours whose windings agree. So
    each part appears twice too, but a part that cannot be wound consistently, such as a Moebius strip, appears once.
    """
    t, (one, other) = len(faces), edges.adjacency.T
    turn = np.where(edges.excess[edges.count == 2] != 0, t, 0)
    label = connected(np.concatenate([[one, other + turn], [one + t, other + t - turn]], axis=1).T, 2 * t)
    part = np.minimum(label[:t], label[t:])
    turned = label[:t] != part
    turned ^= (2 * np.bincount(part, turned, t) > np.bincount(part, minlength=t))[part]
    return np.where(turned[:, None], faces[:, ::-1], faces)


def inward_parts(positions: Floats, faces: Ints, adjacency: Ints, flipped: Bools, volume: float) -> Bools:
    """Return which faces (t,) belong to parts that are inside out; an inward part inside another is a cavity and stays.

    Args:
        positions: (n, 3) [m].
        faces: (t, 3) with consistent winding.
        adjacency: (a, 2) pairs of faces that share an edge.
        flipped: (t,) flipped by `consistent_winding`; an open part without such a face is left as it is.
        volume: volume of the whole mesh with its holes closed [m3].
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
    for part in np.flatnonzero(volumes < -EXACT * terms):  # a flat part has no inside
        mine = label == part
        if flipped[mine].any() or not edges_of(faces[mine]).excess.any():
            inward[mine] = not _inside(corners[~mine], corners[mine][0, 0])
    return inward


def _inside(triangles: Floats, point: Floats) -> bool:
    """Return whether triangles (t, 3, 3) enclose a point (3,), by their winding number.

    Source: van Oosterom and Strackee 1983.
    """
    r = triangles - point
    length = np.linalg.norm(r, axis=2)
    a, b, c = r[:, 0], r[:, 1], r[:, 2]
    below = length.prod(axis=1) + sum(
        (p * q).sum(axis=1) * length[:, k] for p, q, k in ((a, b, 2), (b, c, 0), (c, a, 1))
    )
    return abs(2 * np.arctan2(np.linalg.det(r), below).sum()) > 2 * np.pi
