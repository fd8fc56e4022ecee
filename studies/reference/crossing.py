"""Which triangles pass through each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from core.base import Bools, Floats, Ints
from core.native.scene import Crossings

from .proximity import Surfaces, near_boxes


def find_crossings(s: Surfaces, x: Floats, free: Bools, itself: Sequence[bool], left_out: Bools) -> Crossings:
    """Count the pairs of triangles that pass through each other at positions x (n, 3) [m], and say where the first is.

    Args:
        free: (k,) which surfaces are bodies and props; the others are colliders, which may pass through each other.
        itself: which bodies may not pass through themselves.
        left_out: (n,) of which vertices that does not matter.
    """
    total, first = 0, ((0, 0), np.zeros(3))
    for a in range(len(free)):
        for b in range(a, len(free)):
            if not (a < len(itself) and itself[a] if a == b else free[a] or free[b]):
                continue
            i, j = _crossing(s, x, a, b)
            if a == b:
                met = ~(left_out[s.corners[i]].any(axis=1) | left_out[s.corners[j]].any(axis=1))
                i, j = i[met], j[met]
            if len(i) and not total:
                first = (a, b), x[s.corners[[i[0], j[0]]]].mean(axis=(0, 1))
            total += len(i)
    return Crossings(total, first[0], (float(first[1][0]), float(first[1][1]), float(first[1][2])))


def crossing_vertices(s: Surfaces, x: Floats, body: int) -> Ints:
    """Return the vertices of the triangles of a body that pass through each other at positions x (n, 3) [m]."""
    return np.unique(s.corners[np.concatenate(_crossing(s, x, body, body))])


def _crossing(s: Surfaces, x: Floats, a: int, b: int) -> tuple[Ints, Ints]:
    """Return which triangles of two surfaces pass through each other."""
    owner = s.of_vertex[s.corners[:, 0]]
    ones, others = (np.flatnonzero(owner == which) for which in (a, b))
    i, j = near_boxes(x[s.corners[ones]], x[s.corners[others]], 1e-300)
    i, j = ones[i], others[j]
    apart = (s.corners[i][:, :, None] != s.corners[j][:, None]).all(axis=(1, 2)) & ((a != b) | (i < j))
    i, j = i[apart], j[apart]
    crossed = _cross(x[s.corners[i]], x[s.corners[j]])
    return i[crossed], j[crossed]


def _cross(t: Floats, u: Floats) -> Bools:
    """Return whether an edge of one triangle (m, 3, 3) passes through the other."""
    found = np.zeros(len(t), bool)
    for one, other in ((t, u), (u, t)):
        for k in range(3):
            found |= _passes(one[:, k], one[:, (k + 1) % 3], other)
    return found


def _passes(a: Floats, b: Floats, t: Floats) -> Bools:
    """Return whether segments ab (m, 3) pass through triangles (m, 3, 3)."""
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    slope = np.einsum("mc,mc->m", b - a, n)
    with np.errstate(all="ignore"):
        share = np.einsum("mc,mc->m", t[:, 0] - a, n) / slope
        inside = (slope != 0) & (share >= 0) & (share <= 1)
        point = a + share[:, None] * (b - a)
        for k in range(3):
            edge = t[:, (k + 1) % 3] - t[:, k]
            inside &= np.einsum("mc,mc->m", np.cross(edge, point - t[:, k]), n) >= 0
    return inside
