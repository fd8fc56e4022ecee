"""Intersection of a ray with a surface: the point under the pointer.

Testing every triangle takes a millisecond for 40,000. A tree of boxes would be out of date after each step, and
trimesh's own rays need rtree, which Blender does not include.
"""

from __future__ import annotations

import numpy as np

from ..base import Floats, Ints
from ..vectors import Vector


def ray_hit(
    origin: Vector, direction: Vector, positions: Floats, triangles: Ints
) -> tuple[float, Vector, Vector] | None:
    """Return the nearest intersection of a ray with a surface.

    Args:
        origin: start of the ray [m].
        direction: unit vector of the ray.
        positions: (n, 3) [m].
        triangles: (t, 3).

    Returns:
        Distance [m], point [m] and unit normal on the side from which the ray comes; None if it misses.
    """
    o, d = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
    # in a projection along the ray, the ray is a point; a triangle contains it if it lies on the same side of all three
    # edges. the two triangles at an edge compute the same number for it, so that no ray slips between them
    across = np.eye(3)[np.abs(d).argmin()]
    across = np.cross(d, across) / np.linalg.norm(np.cross(d, across))
    flat = (positions - o) @ np.stack([across, np.cross(d, across)], axis=1)
    # most triangles lie wholly on one side of the ray along one of the two axes: a byte per vertex is enough for these
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
