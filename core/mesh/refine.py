"""Cut triangles whose edges are too long for a fingertip, in the shape they have.

Long edges are halved, round by round, and between triangles that lie nearly in one plane edges are flipped to
Delaunay's, so that fans and slivers become even: across blunt triangles a dent has corners. The sides of a narrow strip
come first, for what lies across it is short then, and a vertex in its middle too many. The vertices there were come
first, bit for bit, so what is known of them is known of the refined surface: a new vertex has the mean of the two ends
of its edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Floats, Ints, sums_at

COARSE = 1.1  # fingertip radii: between longer edges there is no room for the dent of one, and
COARSE_SHARE = 0.05  # of the surface between such edges is enough for that to be met
FINE = 0.83  # fingertip radii: the longest edge that is left, so that a dent of one has a vertex on each side
MOST = 8000  # vertices: more do not run live beside Blender's own work
LONGER = 1.1  # times as long may edges be where that leaves too many vertices
EVEN = 0.45  # of the square of the longest edge: area of a vertex where all edges are about as long
NARROW = 0.6  # of the longest edge: how wide a strip is at most that gets no vertex in its middle
STEP = 0.7  # of the longest edge: what is halved in one round
ROUNDS, FLIPS = 40, 24
FLAT = 0.01  # below 1: cosine between the normals of triangles nearly in one plane, within 8 degrees


@dataclass(frozen=True, slots=True, kw_only=True)
class Refinement:
    """How a surface was refined.

    before: how many vertices there were; they come first.
    rounds: (m, 2) of each round, the ends of the edges that were halved.
    triangles: (t, 3) of the refined surface.
    origin: (t,) for each the triangle it had its material from.
    """

    before: int
    rounds: tuple[Ints, ...]
    triangles: Ints
    origin: Ints

    def at_vertices(self, values: Floats) -> Floats:
        """Return what is known of each vertex there was, (N,) or (N, k), at each vertex of the refined surface."""
        for ends in self.rounds:
            values = np.concatenate([values, (values[ends[:, 0]] + values[ends[:, 1]]) / 2])
        return values

    def least_at_vertices(self, values: Floats) -> Floats:
        """Return as `at_vertices`, but halfway along an edge what is the less at its ends: pins do not spread."""
        for ends in self.rounds:
            values = np.concatenate([values, values[ends].min(axis=1)])
        return values


def is_coarse(positions: Floats, triangles: Ints, radius: float) -> bool:
    """Tell whether the edges of a surface (N, 3) [m] are too long for the dent of a fingertip of a radius [m]."""
    areas, longest = _sizes(positions, triangles)
    return float(areas[longest > COARSE * radius].sum()) > COARSE_SHARE * float(areas.sum())


def refine(positions: Floats, triangles: Ints, kinds: Ints, radius: float, *, most: int = MOST) -> Refinement:
    """Halve edges until none is too long for a fingertip, or for so many vertices.

    Args:
        positions: (N, 3) [m].
        triangles: (t, 3).
        kinds: (t,) edges are flipped between triangles of one kind only.
        radius: of the fingertip [m].
        most: vertices, or half as many again as there are.
    """
    areas, _ = _sizes(positions, triangles)
    most = max(most, 3 * len(positions) // 2)
    longest = max(FINE * radius, float(np.sqrt(areas.sum() / (EVEN * most))))
    while True:
        if found := _refined(positions, triangles, kinds, longest, most):
            return found
        longest *= LONGER


def _refined(positions: Floats, triangles: Ints, kinds: Ints, longest: float, most: int) -> Refinement | None:
    """Halve edges until none is longer than this [m]; None where that takes more vertices than so many."""
    found: list[Ints] = []
    origin, now = np.arange(len(triangles)), positions
    triangles = np.asarray(triangles, np.int64)
    for _ in range(ROUNDS):
        triangles = _flipped(now, triangles, kinds[origin])
        edges, of_triangle = _edges(triangles, len(now))
        lengths = np.linalg.norm(now[edges[:, 0]] - now[edges[:, 1]], axis=1)
        # across a narrow strip only where nothing else is left: once its sides are cut, flips make it short
        cut = np.where(_across_strip(now, triangles, of_triangle, lengths, longest), 0.0, lengths)
        cut = cut if cut.max() > longest else lengths
        long = cut > max(longest, STEP * float(cut.max()))  # the longest first: then flips have room
        if not long.any():
            break
        if len(now) + int(long.sum()) > most:
            return None
        middle = np.where(long, len(now) + np.cumsum(long) - 1, -1)
        found.append(edges[long])
        now = np.concatenate([now, (now[edges[long, 0]] + now[edges[long, 1]]) / 2])
        triangles, parent = _cut(now, triangles, middle[of_triangle])
        origin = origin[parent]
    return Refinement(before=len(positions), rounds=tuple(found), triangles=triangles, origin=origin)


def _across_strip(positions: Floats, triangles: Ints, of_triangle: Ints, lengths: Floats, longest: float) -> Bools:
    """Return which edges (m,) lie between two triangles in one plane that are both narrower than what is to be left."""
    areas, _ = _sizes(positions, triangles)
    half, every = of_triangle.ravel(), np.repeat(areas, 3)
    count = np.bincount(half, minlength=len(lengths))
    normals = np.repeat(_unit_normals(positions, triangles), 3, axis=0)
    mean = np.stack([sums_at(half, axis, len(lengths)) for axis in normals.T]) / np.maximum(count, 1)
    widest = np.zeros(len(lengths))
    np.maximum.at(widest, half, every)
    flat = (mean**2).sum(axis=0) > 1 - FLAT / 2
    return (count == 2) & flat & (2 * widest < NARROW * longest * lengths)


def _sizes(positions: Floats, triangles: Ints) -> tuple[Floats, Floats]:
    """Return the area (t,) [m2] and the longest edge (t,) [m] of triangles."""
    corners = positions[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    return areas, np.linalg.norm(sides, axis=2).max(axis=1)


def _edges(triangles: Ints, n: int) -> tuple[Ints, Ints]:
    """Return every edge once (m, 2), and those of each triangle (t, 3): from its corner 0 to 1, 1 to 2, 2 to 0."""
    low = np.minimum(triangles, np.roll(triangles, -1, axis=1)).ravel()
    high = np.maximum(triangles, np.roll(triangles, -1, axis=1)).ravel()
    unique, inverse = np.unique(low * n + high, return_inverse=True)
    return np.stack([unique // n, unique % n], axis=1), inverse.reshape(-1, 3)


def _cut(positions: Floats, triangles: Ints, middle: Ints) -> tuple[Ints, Ints]:
    """Cut triangles (t, 3) at the middles (t, 3) of their edges, -1 where one stays whole.

    Returns:
        the triangles, and for each the one it is a part of.
    """
    halved = (middle >= 0).sum(axis=1)
    index = np.arange(len(triangles))
    # turned so that of one halved edge it is the first, of two the last is whole
    first, whole = (middle >= 0).argmax(axis=1), (middle < 0).argmax(axis=1)
    turn = np.where(halved == 1, first, np.where(halved == 2, whole + 1, 0))
    order = (turn[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles, order, axis=1).T
    p, q, r = np.take_along_axis(middle, order, axis=1).T
    parts, parents = [triangles[halved == 0]], [index[halved == 0]]

    def add(which: Ints, *rows: tuple[Ints, Ints, Ints]) -> None:
        for row in rows:
            parts.append(np.stack([each[which] for each in row], axis=1))
            parents.append(index[which])

    add(halved == 1, (a, p, c), (p, b, c))
    across = np.linalg.norm(positions[a] - positions[q], axis=1) <= np.linalg.norm(positions[p] - positions[c], axis=1)
    two = halved == 2
    add(two, (p, b, q))
    add(two & across, (a, p, q), (a, q, c))
    add(two & ~across, (a, p, c), (p, q, c))
    add(halved == 3, (a, p, r), (p, b, q), (r, q, c), (p, q, r))
    return np.concatenate(parts), np.concatenate(parents)


def _flipped(positions: Floats, triangles: Ints, kinds: Ints) -> Ints:
    """Return triangles with edges flipped to Delaunay's where the surface is nearly flat."""
    triangles = triangles.copy()
    for _ in range(FLIPS):
        flips = _flips(positions, triangles, kinds)
        if not len(flips):
            break
        (one, other), (a, b, c, d) = flips[:, :2].T, flips[:, 2:].T
        triangles[one], triangles[other] = np.stack([a, d, c], axis=1), np.stack([d, b, c], axis=1)
    return triangles


def _flips(positions: Floats, triangles: Ints, kinds: Ints) -> Ints:
    """Return edges to flip, no two of one triangle: rows of two triangles, their edge a b, and what is opposite."""
    n = len(positions)
    edges, of_triangle = _edges(triangles, n)
    half = of_triangle.ravel()
    count = np.bincount(half, minlength=len(edges))
    order = np.argsort(half, kind="stable")
    starts = np.cumsum(count) - count
    pairs = np.flatnonzero(count == 2)
    first, second = order[starts[pairs]], order[starts[pairs] + 1]
    one, other, corner, mate = first // 3, second // 3, first % 3, second % 3
    a, b, c = (triangles[one, (corner + k) % 3] for k in range(3))
    b2, a2, d = (triangles[other, (mate + k) % 3] for k in range(3))
    whole = (a == a2) & (b == b2) & (c != d) & (kinds[one] == kinds[other])
    normals = _unit_normals(positions, triangles)
    whole &= (normals[one] * normals[other]).sum(axis=1) > 1 - FLAT
    sharp = _cotangent(positions, a, b, c) + _cotangent(positions, a, b, d)
    gain = np.where(whole, sharp, 0.0)
    best = np.zeros(len(triangles))
    np.minimum.at(best, one, gain)
    np.minimum.at(best, other, gain)
    taken = (gain < -1e-6) & (gain == best[one]) & (gain == best[other])
    there = np.minimum(c, d) * n + np.maximum(c, d)
    taken &= ~np.isin(there, edges[:, 0] * n + edges[:, 1])
    rows = np.stack([one, other, a, b, c, d], axis=1)[taken]
    # two gains that are equal to the bit may meet in one triangle
    used = sums_at(rows[:, :2].ravel(), np.ones(2 * len(rows)), len(triangles))
    clear = (used[rows[:, :2]] == 1).all(axis=1)
    return rows[clear] if clear.any() else rows[:1]


def _unit_normals(positions: Floats, triangles: Ints) -> Floats:
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def _cotangent(positions: Floats, a: Ints, b: Ints, at: Ints) -> Floats:
    """Return the cotangent (m,) of the angle under which an edge is seen from a vertex."""
    u, v = positions[a] - positions[at], positions[b] - positions[at]
    across = np.linalg.norm(np.cross(u, v), axis=1)
    return (u * v).sum(axis=1) / np.maximum(across, 1e-12 * (u * u).sum(axis=1) + 1e-300)
