"""The edges of a surface, all from one sort: the faces at each, and the half-edges that lead round a vertex.

Half-edge 3 f + c goes from corner c of face f to the next corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Ints


@dataclass(frozen=True, slots=True, kw_only=True)
class Edges:
    """The edges of t triangles.

    ends: (m, 2) vertices of every edge, sorted by (first, second), first < second.
    count: (m,) number of faces at each edge.
    faces: (m, 2) the first and the last of these faces.
    excess: (m,) number of faces that traverse the edge from its first end to its second, minus the others.
    of_half: (3 t,) the edge of each half-edge.
    twin: (3 t,) the opposite half-edge if exactly two faces of consistent winding share the edge, else -1.
    """

    ends: Ints
    count: Ints
    faces: Ints
    excess: Ints
    of_half: Ints
    twin: Ints

    @property
    def consistent(self) -> bool:
        """Return whether the winding of all neighbouring faces is consistent."""
        return not self.excess[self.count == 2].any()

    @property
    def adjacency(self) -> Ints:
        """Return the pairs of faces (a, 2) that share an edge with no third face."""
        return self.faces[self.count == 2]

    @property
    def border(self) -> Ints:
        """Return the edges (c, 2) that caps must add so that every edge is traversed equally often in both directions.

        The border of any set of oriented faces consists of cycles, so a cone over each part of it closes even a
        non-manifold mesh: the pressure then exerts no net force, and an interior wall counts as skin only.
        """
        open_ones = np.flatnonzero(self.excess)
        walked, excess = self.ends[open_ones], self.excess[open_ones]
        walked[excess < 0] = walked[excess < 0][:, ::-1]
        order = np.lexsort((walked[:, 1], walked[:, 0]))
        return np.repeat(walked[order][:, ::-1], np.abs(excess[order]), axis=0)


def edges_of(triangles: Ints) -> Edges:
    """Return the edges of triangles (t, 3) with three different corners each."""
    start, end = triangles.ravel(), np.take(triangles, (1, 2, 0), axis=1).ravel()
    keys = np.minimum(start, end) << 32 | np.maximum(start, end)
    order = np.argsort(keys, kind="stable")
    keys = keys.take(order)
    new = np.ones(len(keys), bool)
    np.not_equal(keys[1:], keys[:-1], out=new[1:])
    first = np.flatnonzero(new)
    count = np.diff(first, append=len(keys))
    of_half = np.empty(len(keys), np.int64)
    of_half[order] = np.cumsum(new) - 1
    ways = np.where(start < end, np.int8(1), np.int8(-1)).take(order)
    excess = np.add.reduceat(ways, first, dtype=np.int64) if len(first) else first
    pairs = first[(count == 2) & (excess == 0)]
    one, other = order.take(pairs), order.take(pairs + 1)
    twin = np.full(len(keys), -1)
    twin[one], twin[other] = other, one
    keys, ends = keys.take(first), np.empty((len(first), 2), np.int64)
    ends[:, 0], ends[:, 1] = keys >> 32, keys & 0xFFFFFFFF
    faces = np.stack([order.take(first), order.take(first + count - 1)], axis=1)
    faces //= 3
    return Edges(ends=ends, count=count, faces=faces, excess=excess, of_half=of_half, twin=twin)
