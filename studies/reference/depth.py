"""How deep a fingertip is below the surface at rest: the x of Eq. (1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.base import Floats, Ints
from core.body.shape_matching import Pose
from core.mesh.surface import Mesh

from .facets import nearest_on_triangles

SAME_SIDE = 0.5  # cosine: a deep fingertip may be nearer to another side than to the one it entered through


@dataclass(frozen=True, slots=True, kw_only=True)
class RestSurface:
    """The triangles of a surface at rest.

    corners: (3, t, 3) coordinate, triangle, corner [m].
    normals: (3, t) unit vectors, outward.
    middles: (3, t) mean of the corners [m].
    extents: (t,) distance from the middle to the farthest corner [m].
    """

    corners: Floats
    normals: Floats
    middles: Floats
    extents: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Touching:
    """How a fingertip meets the surface at rest, which the body carries along.

    depth: of the fingertip's lowest point below the surface [m], negative where it is clear.
    outward: (3,) unit vector, the way out of the body.
    triangle: index of the nearest.
    centre: (3,) of the fingertip [m].
    local: (3,) the same in the space of the shape at rest [m].
    pose: rotation and translation of the shape at rest.
    """

    depth: float
    outward: Floats
    triangle: int
    centre: Floats
    local: Floats
    pose: Pose


def rest_surface(mesh: Mesh) -> RestSurface:
    """Prepare a mesh for `touching`."""
    corners = mesh.rest_positions[mesh.triangles].transpose(2, 0, 1)
    a, b, c = corners[:, :, 0], corners[:, :, 1], corners[:, :, 2]
    normals = np.cross(b - a, c - a, axis=0)
    middles = corners.mean(axis=2)
    return RestSurface(
        corners=np.ascontiguousarray(corners),
        normals=normals / np.maximum(np.linalg.norm(normals, axis=0), 1e-30),
        middles=middles,
        extents=np.sqrt(((corners - middles[:, :, None]) ** 2).sum(axis=0).max(axis=1)),
    )


def touching(surface: RestSurface, pose: Pose, centre: Floats, radius: float, side: Floats | None = None) -> Touching:
    """Return how a fingertip meets the surface at rest in its pose.

    Args:
        surface: triangles at rest.
        pose: where the shape at rest is now.
        centre: (3,) of the fingertip [m].
        radius: of the fingertip [m].
        side: (3,) outward normal, in the space of the shape at rest, where the fingertip entered; only triangles
            facing that way count.
    """
    rotation, translation = pose
    local = rotation.T @ (centre - translation)
    facing = np.ones(len(surface.extents), bool) if side is None else side @ surface.normals > SAME_SIDE
    if not facing.any():
        facing[:] = True
    away = np.sqrt(((surface.middles - local[:, None]) ** 2).sum(axis=0))
    limit = (away + surface.extents)[facing].min()
    near: Ints = np.flatnonzero(facing & (away - surface.extents <= limit))
    weights = nearest_on_triangles(surface.corners[:, near], local)
    offset = local[:, None] - (surface.corners[:, near] * weights).sum(axis=2)
    distance = np.sqrt((offset**2).sum(axis=0))
    heights = (offset * surface.normals[:, near]).sum(axis=0)
    # beside an edge several triangles are equally near: the one that faces the point most directly gives the sign
    tied = np.flatnonzero(distance <= distance.min() * (1 + 1e-9) + 1e-12)
    best = tied[np.abs(heights[tied]).argmax()]
    height, triangle = float(distance[best] if heights[best] >= 0 else -distance[best]), int(near[best])
    # the direction in which depth falls fastest; on the surface itself that is the normal
    outward = offset[:, best] / height if abs(height) > 1e-6 * radius else surface.normals[:, triangle]
    return Touching(
        depth=radius - height, outward=rotation @ outward, triangle=triangle, centre=centre, local=local, pose=pose
    )
