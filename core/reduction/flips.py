"""Edge flips: triangles whose edges are those of Delaunay, with no blunt angles facing each other across an edge.

Where the angles opposite an edge sum to more than a half turn, its cotangent weight is negative: the tension of shape
matching has to leave it out, and slivers lean a dent to one side. The other diagonal of the two is better then.
Source: Lawson 1977.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import Floats, Ints

FLAT = 0.5  # cosine: the two new triangles must face nearly as the old ones did
ROUNDING = 1e-9  # of a cotangent
MOST_LOOKS = 20  # at an edge, on average
Point = tuple[float, float, float]
Edge = tuple[int, int]


def flip_edges(points: Floats, triangles: Ints) -> Ints:
    """Return triangles (t, 3) on the same points (n, 3), blunt edges flipped where the surface is nearly flat there."""
    corners, x = [tuple(corner) for corner in triangles.tolist()], [tuple(point) for point in points.tolist()]
    sides: dict[Edge, list[int]] = {}
    for k, (a, b, c) in enumerate(corners):
        for i, j in ((a, b), (b, c), (c, a)):
            sides.setdefault((min(i, j), max(i, j)), []).append(k)
    waiting, looks = _blunt(points, triangles), MOST_LOOKS * len(sides)
    while waiting and looks:
        looks -= 1
        edge = waiting.pop()
        beside = sides.get(edge, [])
        if len(beside) != 2:
            continue
        a, b = beside
        i, j = edge
        if corners[a][(corners[a].index(i) + 1) % 3] != j:
            a, b = b, a
        k, m = (next(v for v in corners[side] if v not in edge) for side in (a, b))
        other = (min(k, m), max(k, m))
        if k == m or other in sides or not _is_better(x[i], x[j], x[k], x[m]):
            continue
        corners[a], corners[b] = (k, i, m), (m, j, k)
        del sides[edge]
        sides[other] = [a, b]
        for ends, before, now in (((i, m), b, a), ((j, k), a, b)):
            those = sides[min(ends), max(ends)]
            those[those.index(before)] = now
        waiting += [(min(p, q), max(p, q)) for p in edge for q in other]
    return np.array(corners, dtype=triangles.dtype)


def _blunt(points: Floats, triangles: Ints) -> list[Edge]:
    """Return the edges whose opposite angles sum to more than a half turn."""
    i, j, k = (np.roll(triangles, -turn, axis=1).ravel() for turn in range(3))
    p, q = points[i] - points[k], points[j] - points[k]
    area = np.linalg.norm(np.cross(p, q), axis=1)
    edge, where = np.unique(np.minimum(i, j) * len(points) + np.maximum(i, j), return_inverse=True)
    cotangents = np.bincount(where, (p * q).sum(axis=1) / np.maximum(area, 1e-30))
    return list(zip(*(ends.tolist() for ends in np.divmod(edge[cotangents < -ROUNDING], len(points))), strict=True))


def _is_better(i: Point, j: Point, k: Point, m: Point) -> bool:
    """Tell whether triangles k i m and m j k are better than i j k and j i m: less blunt, and as flat."""
    near, far = _normal(i, j, k), _normal(j, i, m)
    if _cotangent(k, i, j, near) + _cotangent(m, i, j, far) >= -ROUNDING:
        return False
    old = near[0] + far[0], near[1] + far[1], near[2] + far[2]
    new = _normal(k, i, m), _normal(m, j, k)
    return all(_dot(normal, old) > FLAT * math.hypot(*normal) * math.hypot(*old) for normal in new)


def _cotangent(at: Point, p: Point, q: Point, normal: Point) -> float:
    return _dot(_way(at, p), _way(at, q)) / max(math.hypot(*normal), 1e-30)


def _normal(a: Point, b: Point, c: Point) -> Point:
    (p, q, r), (u, v, w) = _way(a, b), _way(a, c)
    return q * w - r * v, r * u - p * w, p * v - q * u


def _way(a: Point, b: Point) -> Point:
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
