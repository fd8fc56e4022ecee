"""A face beside a fingertip: its nearest point, its way in, and which sphere it meets.

Faces keep a fingertip smaller than an edge from slipping through. A facet stands for a surface that bends round the
fingertip: where its corners lie on the sphere, its middle lies inside by the bulge

    s = (|e_12|^2 + |e_23|^2 + |e_31|^2) / 18 R

with edges e at rest. To push there too would be to ask for twice what there is to move, and the surplus would show as
side force and creep. So a facet meets a sphere smaller by 0.16 R: its corners alone keep a small one out, and where
they part under the fingertip, the stretched facet holds it. One too large to bend (s > 0.09 R) meets a sphere smaller
by R / 4 - s, and a vertex the whole sphere. (One sphere for all of a facet, or a contact that slides on it would gain
energy.)
"""

from __future__ import annotations

import numpy as np

from core.base import Bools, Floats, Ints

from .constants import TRAVEL

_TINY = 1e-30


def faces_near(x: Floats, triangles: Ints, inverse_mass: Floats, centre: Floats, reach: float) -> Ints:
    """Return which triangles (t,) can move and whose bounding sphere is within reach [m] of a place (3,)."""
    corners = x[:, triangles.T]
    middle = corners.sum(axis=1) / 3
    extent = np.sqrt(((corners - middle[:, None]) ** 2).sum(axis=0).max(axis=0))
    hit = ((middle - centre[:, None]) ** 2).sum(axis=0) < (reach + extent) ** 2
    return np.flatnonzero(hit & (inverse_mass[triangles] > 0).any(axis=1))


def met_radius(bulge: Floats, radius: float, sunk: Floats | float) -> Floats:
    """Return the radii (c,) [m] of the spheres that facets of a bulge at rest (c,) [m] meet: smaller by sunk [m]."""
    return radius - np.minimum(sunk, np.maximum(TRAVEL * radius - bulge, 0.0))


def bulge(corners: Floats, radius: float) -> Floats:
    """Return how far (c,) [m] a sphere bulges beyond the middle of facets (3, c, 3) whose corners lie on it."""
    edges = corners - np.roll(corners, 1, axis=2)
    return np.asarray((edges * edges).sum(axis=(0, 2)) / (18 * radius))


def inward_normals(corners: Floats) -> Floats:
    """Return the inward unit normals (3, c) of faces (3, c, 3): a fingertip came from outside."""
    a, b, c = corners.transpose(2, 0, 1)
    normal = np.cross(c - a, b - a, axis=0)
    return normal / np.maximum(np.sqrt((normal**2).sum(axis=0)), _TINY)


def nearest_on_triangles(corners: Floats, point: Floats) -> Floats:
    """Return the barycentric weights (t, 3) of the points of triangles (3, t, 3) nearest to a point (3,).

    Source: Ericson, Real-Time Collision Detection, 5.1.5: which of the seven Voronoi regions holds the point.
    """
    a, b, c = corners[:, :, 0], corners[:, :, 1], corners[:, :, 2]
    ab, ac = b - a, c - a
    p = point[:, None]
    d1, d2 = (ab * (p - a)).sum(axis=0), (ac * (p - a)).sum(axis=0)
    d3, d4 = (ab * (p - b)).sum(axis=0), (ac * (p - b)).sum(axis=0)
    d5, d6 = (ab * (p - c)).sum(axis=0), (ac * (p - c)).sum(axis=0)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    on_bc = _ratio(d4 - d3, (d4 - d3) + (d5 - d6))
    v, w = _ratio(vb, va + vb + vc), _ratio(vc, va + vb + vc)
    # the first region that holds wins, so it comes last
    regions: list[tuple[Bools, Floats | float, Floats | float]] = [
        ((va <= 0) & (d4 >= d3) & (d5 >= d6), 1 - on_bc, on_bc),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), 0.0, _ratio(d2, d2 - d6)),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), _ratio(d1, d1 - d3), 0.0),
        ((d6 >= 0) & (d5 <= d6), 0.0, 1.0),
        ((d3 >= 0) & (d4 <= d3), 1.0, 0.0),
        ((d1 <= 0) & (d2 <= 0), 0.0, 0.0),
    ]
    for holds, at_v, at_w in regions:
        v, w = np.where(holds, at_v, v), np.where(holds, at_w, w)
    return np.stack([1 - v - w, v, w], axis=1)


def _ratio(part: Floats, whole: Floats) -> Floats:
    return part / np.where(np.abs(whole) > _TINY, whole, 1.0)
