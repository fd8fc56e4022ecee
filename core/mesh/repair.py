"""The repair of a surface: near vertices are welded, winding is made consistent, closed parts face outward.

trimesh's own functions for these need scipy or networkx, and Blender has neither.
"""

from __future__ import annotations

import numpy as np

from ..base import Bools, Floats, Ints, sums_at
from ..constants import EXACT
from .edges import Edges, edges_of

SLANTED = np.array([0.3517, 0.5843, 0.7313])  # of length 1; hardly any two points of a mesh are level along it


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
    """Find the vertices to merge: all that are nearer than half a cell [m] along each axis, and so on from each to the
    next.

    trimesh's own `merge_vertices` rounds to one grid, and so leaves near vertices apart where a grid line runs between.

    Args:
        positions: (N, 3) [m].

    Returns:
        one vertex of each merged group (n,), and the group of every vertex (N,).
    """
    along = positions @ SLANTED
    order = np.argsort(along)
    along, left, pairs = along[order], np.arange(len(order)), [np.zeros((0, 2), np.int64)]
    for step in range(1, len(order)):  # in this order near vertices are few places apart
        left = left[: np.searchsorted(left, len(order) - step)]
        left = left[along.take(left + step) - along.take(left) <= cell]
        if not len(left):
            break
        both = np.stack([order.take(left), order.take(left + step)], axis=1)
        apart = np.abs(positions[both[:, 0]] - positions[both[:, 1]]).max(axis=1)
        pairs.append(both[apart < cell / 2])
        left = left[apart > 0]  # one at the very same place is near to the same ones
    kept, source = np.unique(connected(np.concatenate(pairs), len(positions)), return_inverse=True)
    return kept, source


def consistent_winding(faces: Ints, edges: Edges) -> Ints:
    """Return the faces (t, 3) wound as their neighbours are; most faces of each part keep their winding.

    Each face stands twice, as it is and turned over, and is joined to its neighbours as they are wound alike: so each
    part stands twice too, and a part that cannot be wound alike, a Moebius strip, once.
    """
    t, (one, other) = len(faces), edges.adjacency.T
    turn = np.where(edges.excess[edges.count == 2] != 0, t, 0)
    label = connected(np.concatenate([[one, other + turn], [one + t, other + t - turn]], axis=1).T, 2 * t)
    part = np.minimum(label[:t], label[t:])
    turned = label[:t] != part
    turned ^= (2 * np.bincount(part, turned, t) > np.bincount(part, minlength=t))[part]
    return np.where(turned[:, None], faces[:, ::-1], faces)


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
