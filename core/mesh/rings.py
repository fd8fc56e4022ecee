"""Ordered one-rings: the memory layout of every hot loop, here and in the native core.

The neighbours j_0 .. j_(v-1) of a vertex i, in order round it, give both its springs and its normal in one gather:
the sum of (x_s - x_i) x (x_(s+1) - x_i) over the ring is twice the area-weighted normal of its faces.
A vertex whose faces form one closed fan of at most MAX_RING is regular. The others (on borders, on non-manifold edges,
in wider fans) are irregular: they have no ring, and their faces and springs are listed and summed one by one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Ints

MAX_RING = 12  # one wide fan must not widen every row


@dataclass(frozen=True, slots=True, kw_only=True)
class Rings:
    """One-rings, slot by slot.

    neighbours: (w, n) vertex in each slot; past the last one the first is repeated, so a padded slot spans no area.
    springs: (w, n) spring to that neighbour, -1 in padded slots.
    regular: (n,) has a ring.
    corners: (c, 3) triangles rotated so that their first corner is irregular.
    irregular_springs: (l,) springs with an irregular end.
    irregular_ends: (l, 2) which of its ends are irregular.
    """

    neighbours: Ints
    springs: Ints
    regular: Bools
    corners: Ints
    irregular_springs: Ints
    irregular_ends: Bools


def ordered_rings(triangles: Ints, springs: Ints, n: int) -> Rings:
    """Order the neighbours of every vertex.

    Args:
        triangles: (t, 3) with consistent winding.
        springs: (m, 2), sorted by (first, second), first < second.
        n: number of vertices.
    """
    corners = np.concatenate([triangles, np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)])
    keys = corners[:, 0] * n + corners[:, 1]
    order = np.argsort(keys, kind="stable")
    keys, after = keys[order], corners[order, 2]
    valence = np.bincount(corners[:, 0], minlength=n)
    regular = (valence >= 3) & (valence <= MAX_RING)
    regular[keys[1:][keys[1:] == keys[:-1]] // n] = False

    width = int(valence[regular].max()) if regular.any() else 0
    first = np.zeros(n, np.int64)
    first[corners[::-1, 0]] = corners[::-1, 1]
    ring = np.empty((width, n), np.int64)
    here = first.copy()
    for slot in range(width):
        # walk to the next neighbour; past the last stay at the first
        ring[slot] = np.where(slot < valence, here, first)
        wanted = np.arange(n) * n + here
        at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        regular &= (keys[at] == wanted) | (slot >= valence)
        here = np.where(slot < valence, after[at], here)
        # back at the start too early: two fans meet in this vertex
        regular &= ~((here == first) & (slot < valence - 1))
    regular &= here == first
    ring[:, ~regular] = np.flatnonzero(~regular)

    spring_keys = springs[:, 0] * n + springs[:, 1]
    low, high = np.minimum(ring, np.arange(n)), np.maximum(ring, np.arange(n))
    slots = np.searchsorted(spring_keys, low * n + high)
    ring_springs = np.where((np.arange(width)[:, None] < valence) & regular, slots, -1)
    ends = ~regular[springs]
    return Rings(
        neighbours=ring, springs=ring_springs, regular=regular, corners=corners[~regular[corners[:, 0]]],
        irregular_springs=np.flatnonzero(ends.any(axis=1)), irregular_ends=ends[ends.any(axis=1)],
    )  # fmt: skip
