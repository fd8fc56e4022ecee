"""A ray against a surface: what the pointer is on.

A test of every triangle at once costs a millisecond or two for 40,000; a tree would be stale after each step.
"""

from __future__ import annotations

import numpy as np

from ..base import Floats, Ints

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
    """
    o, d = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
    # seen along the ray it is a point, and a triangle holds it when it is on the same side of all three edges;
    # an edge is judged alike from both its triangles, so that no ray slips between them
    across = np.eye(3)[np.abs(d).argmin()]
    across = np.cross(d, across) / np.linalg.norm(np.cross(d, across))
    flat = (positions - o) @ np.stack([across, np.cross(d, across)], axis=1)
    x, y = (np.ascontiguousarray(flat[:, i])[triangles.T] for i in range(2))
    side = x * np.roll(y, -1, axis=0) - np.roll(x, -1, axis=0) * y
    held = np.flatnonzero((side >= 0).all(axis=0) | (side <= 0).all(axis=0))
    a, b, c = np.asarray(positions, np.float64)[triangles[held]].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    toward = normals @ d
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.einsum("ij,ij->i", a - o, normals) / toward
    distance = np.where(np.isfinite(distance) & (distance > 0), distance, np.inf)
    if not np.isfinite(distance).any():
        return None
    nearest = int(distance.argmin())
    normal = normals[nearest] / np.linalg.norm(normals[nearest]) * -np.sign(toward[nearest])
    return float(distance[nearest]), tuple((o + distance[nearest] * d).tolist()), tuple(normal.tolist())
