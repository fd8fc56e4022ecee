"""Edge flips: triangles whose edges are those of Delaunay, with no blunt angles facing each other across an edge.

Where the angles opposite an edge sum to more than a half turn, its cotangent weight is negative: the tension of shape
matching has to leave it out, and slivers lean a dent to one side. The other diagonal of the two is better then.
Source: Lawson 1977.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import EXACT, Floats, Ints

FLAT = 0.5  # cosine: the two new triangles must face nearly as the old ones did
MOST_LOOKS = 20  # at an edge, on average
Point = tuple[float, float, float]


def flip_edges(points: Floats, triangles: Ints) -> Ints:
    """Return triangles (t, 3) on the same points (n, 3), blunt edges flipped where the surface is nearly flat there.

    Edges are numbers, low x n + high, and so are the two triangles beside one: of pairs and lists there would be so
    many that Python collects its garbage, which holds up all threads for tens of milliseconds.
    """
    n, t = len(points), len(triangles)
    corners, x = triangles.ravel().tolist(), points.ravel().tolist()
    sides, waiting = _sides(triangles, n), _blunt(points, triangles)
    looks = MOST_LOOKS * len(sides)

    def edge_of(p: int, q: int) -> int:
        return min(p, q) * n + max(p, q)

    def point(v: int) -> Point:
        return x[3 * v], x[3 * v + 1], x[3 * v + 2]

    while waiting and looks:
        looks -= 1
        edge = waiting.pop()
        beside = sides.get(edge, -1)
        if beside < 0:
            continue
        (a, b), (i, j) = divmod(beside, t), divmod(edge, n)
        around = corners[3 * a : 3 * a + 3]
        if around[(around.index(i) + 1) % 3] != j:
            a, b = b, a
        k, m = (next(v for v in corners[3 * side : 3 * side + 3] if v not in (i, j)) for side in (a, b))
        other = edge_of(k, m)
        if k == m or other in sides or not _is_better(point(i), point(j), point(k), point(m)):
            continue
        corners[3 * a : 3 * a + 3], corners[3 * b : 3 * b + 3] = (k, i, m), (m, j, k)
        del sides[edge]
        sides[other] = a * t + b
        for ends, before, now in ((edge_of(i, m), b, a), (edge_of(j, k), a, b)):
            if (pair := sides[ends]) >= 0:
                one, two = divmod(pair, t)
                sides[ends] = now * t + two if one == before else one * t + now
        waiting += [edge_of(p, q) for p in (i, j) for q in divmod(other, n)]
    return np.array(corners, dtype=triangles.dtype).reshape(-1, 3)


def _sides(triangles: Ints, n: int) -> dict[int, int]:
    """Return the two triangles beside each edge, first x t + second, -1 where there are not two."""
    i, j, t = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel(), len(triangles)
    edges = np.minimum(i, j) * n + np.maximum(i, j)
    order = np.argsort(edges, kind="stable")
    found, start, count = np.unique(edges[order], return_index=True, return_counts=True)
    first, second = (order[np.minimum(start + at, len(order) - 1)] // 3 for at in (0, 1))
    return dict(zip(found.tolist(), np.where(count == 2, first * t + second, -1).tolist(), strict=True))


def _blunt(points: Floats, triangles: Ints) -> list[int]:
    """Return the edges whose opposite angles sum to more than a half turn."""
    i, j, k = (np.roll(triangles, -turn, axis=1).ravel() for turn in range(3))
    p, q = points[i] - points[k], points[j] - points[k]
    area = np.linalg.norm(np.cross(p, q), axis=1)
    edge, where = np.unique(np.minimum(i, j) * len(points) + np.maximum(i, j), return_inverse=True)
    cotangents = np.bincount(where, (p * q).sum(axis=1) / np.maximum(area, 1e-30))
    blunt: list[int] = edge[cotangents < -EXACT].tolist()
    return blunt


def _is_better(i: Point, j: Point, k: Point, m: Point) -> bool:
    """Tell whether triangles k i m and m j k are better than i j k and j i m: less blunt, and as flat."""
    near, far = _normal(i, j, k), _normal(j, i, m)
    if _cotangent(k, i, j, near) + _cotangent(m, i, j, far) >= -EXACT:
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
