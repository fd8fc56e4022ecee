"""Ordered one-rings: the memory layout of the inner loops of the native core.

The neighbours j_0 .. j_(v-1) of a vertex i, in order round it, give both its springs and its normal in one gather:
the sum of (x_s - x_i) x (x_(s+1) - x_i) over the ring is twice the area-weighted normal of its faces.
A vertex whose faces form one closed fan of at most MAX_RING faces is regular. The others (on borders, on non-manifold
edges, in larger fans) are irregular: they have no ring, and their faces and springs are listed and summed one by one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Ints, row_parts
from ..constants import MAX_RING
from .edges import Edges


@dataclass(frozen=True, slots=True, kw_only=True)
class Rings:
    """One-rings, slot by slot.

    neighbours: (w, n) neighbour in each slot; after the last one the first is repeated, so a padded slot spans no area.
    springs: (w, n) spring to that neighbour, -1 in padded slots.
    corners: (c, 3) triangles rotated so that their first corner is irregular, one entry for each irregular corner.
    irregular_springs: (l,) springs with an irregular end.
    irregular_ends: (l, 2) which ends of these springs are irregular.
    """

    neighbours: Ints
    springs: Ints
    corners: Ints
    irregular_springs: Ints
    irregular_ends: Bools


def ordered_rings(triangles: Ints, edges: Edges, n: int) -> Rings:
    """Order the neighbours of every vertex.

    Args:
        triangles: (t, 3) with consistent winding.
        edges: the edges of these triangles.
        n: number of vertices.
    """
    start, end = triangles.ravel(), np.take(triangles, (1, 2, 0), axis=1).ravel()
    # for each half-edge, the next one round the vertex at which it starts
    turn = np.take(edges.twin.reshape(-1, 3), (2, 0, 1), axis=1).ravel()
    valence = np.bincount(start, minlength=n)
    regular = (valence >= 3) & (valence <= MAX_RING)
    regular[start[turn < 0]] = False

    width = int(valence[regular].max()) if regular.any() else 0
    half, first = np.arange(len(start)).reshape(-1, 3), np.zeros(n, np.int64)
    for corner in (2, 1, 0):  # at each vertex the lowest corner wins, then the first face
        first[triangles[::-1, corner]] = half[::-1, corner]
    ring, springs = np.empty((width, n), np.int64), np.empty((width, n), np.int64)
    for part in row_parts(n):
        here, start_here, count = first[part], first[part], valence[part]
        for slot in range(width):
            # go to the next neighbour; after the last return to the first
            ring[slot, part], springs[slot, part] = end.take(here), edges.of_half.take(here)
            springs[slot, part][slot >= count] = -1
            here = np.where(slot < count - 1, turn.take(here), start_here)
            # back at the start too early: two fans meet at this vertex
            regular[part] &= (here != start_here) | (slot >= count - 1)
    ring[:, ~regular], springs[:, ~regular] = np.flatnonzero(~regular), -1

    odd = np.concatenate([half[~regular.take(triangles[:, corner]), corner] for corner in range(3)])
    apex = end[odd + np.where(odd % 3 == 2, -2, 1)]
    ends = ~regular[edges.ends]
    irregular = np.flatnonzero(ends[:, 0] | ends[:, 1])
    return Rings(
        neighbours=ring, springs=springs, corners=np.stack([start[odd], end[odd], apex], axis=1),
        irregular_springs=irregular, irregular_ends=ends[irregular],
    )  # fmt: skip
