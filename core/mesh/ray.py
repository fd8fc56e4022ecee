"""A ray against a surface: what the pointer is on.

Looking at every triangle costs a millisecond for 40,000. A tree of boxes would be out of date after each step, and
trimesh's own rays need rtree, which Blender has not.
"""

from __future__ import annotations

import numpy as np

from ..base import Floats, Ints
from ..vectors import Vector


def ray_hit(
    origin: Vector, direction: Vector, positions: Floats, triangles: Ints
) -> tuple[float, Vector, Vector] | None:
    """Return the nearest crossing of a ray with a surface.

    Args:
        origin: of the ray [m].
        direction: of the ray, a unit vector.
        positions: (n, 3) [m].
        triangles: (t, 3).

    Returns:
        Distance [m], point [m] and unit normal on the side the ray comes from; None when it misses.
    """
    o, d = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
    # projected along the ray, the ray is a point; a triangle contains it when it lies on the same side of all three
    # edges. both triangles of an edge compute the same number for it, so that no ray slips between them
    across = np.eye(3)[np.abs(d).argmin()]
    across = np.cross(d, across) / np.linalg.norm(np.cross(d, across))
    flat = (positions - o) @ np.stack([across, np.cross(d, across)], axis=1)
    # nearly all have their corners on one side of it, along one of the two axes: a byte a corner tells
    sides = np.packbits(np.concatenate([flat > 0, flat < 0], axis=1), axis=1)[:, 0]
    a, b, c = (sides[triangles[:, corner]] for corner in range(3))
    near = triangles[(a & b & c) == 0]
    x, y = flat[near].transpose(2, 1, 0)
    side = x * np.roll(y, -1, axis=0) - np.roll(x, -1, axis=0) * y
    inside = (side >= 0).all(axis=0) | (side <= 0).all(axis=0)
    a, b, c = np.asarray(positions, np.float64)[near[inside]].transpose(1, 0, 2)
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
