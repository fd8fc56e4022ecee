"""A ray against a surface: what the pointer is on.

A test of every triangle at once costs a millisecond or two for 40,000; a tree would be stale after each step.
"""

from __future__ import annotations

import numpy as np

from .base import Floats, Ints

Vector = tuple[float, float, float]


def ray_hit(
    origin: Vector, direction: Vector, positions: Floats, triangles: Ints
) -> tuple[float, Vector, Vector] | None:
    """Return the nearest crossing of a ray with a surface.

    Args:
        origin, direction: of the ray, the direction a unit vector.
        positions: (n, 3) [m].
        triangles: (t, 3).

    Returns:
        Distance [m], point [m] and unit normal on the side the ray comes from; None when it misses.

    Source: Moeller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997.
    """
    o, d = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
    a, b, c = (np.asarray(positions[triangles[:, i]], np.float64) for i in range(3))
    ab, ac = b - a, c - a
    p = np.cross(d, ac)
    determinant = np.einsum("ij,ij->i", ab, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1 / determinant
        s = o - a
        u = np.einsum("ij,ij->i", s, p) * inverse
        q = np.cross(s, ab)
        v = (q @ d) * inverse
        distance = np.einsum("ij,ij->i", ac, q) * inverse
        # a hair of slack: a ray through an edge must not slip between two triangles
        crossed = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (distance > 0)
    distance = np.where(crossed & np.isfinite(distance), distance, np.inf)
    nearest = int(distance.argmin())
    if distance[nearest] == np.inf:
        return None
    normal = np.cross(ab[nearest], ac[nearest])
    normal /= np.linalg.norm(normal)
    if normal @ d > 0:
        normal = -normal
    return float(distance[nearest]), tuple((o + distance[nearest] * d).tolist()), tuple(normal.tolist())
