"""The points of triangles that are nearest to others."""

from __future__ import annotations

import numpy as np

from ..base import Bools, Floats

_TINY = 1e-30


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


def weights_on_face(p: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Return the weights (m, 3) of the points of triangles nearest to p, all (m, 3).

    Source: Ericson, Real-Time Collision Detection, 5.1.5.
    """
    d1, d2 = _dot(b - a, p - a), _dot(c - a, p - a)
    d3, d4 = _dot(b - a, p - b), _dot(c - a, p - b)
    d5, d6 = _dot(b - a, p - c), _dot(c - a, p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    zero, one = np.zeros_like(va), np.ones_like(va)
    cases = [
        (d1 <= 0) & (d2 <= 0), (d3 >= 0) & (d4 <= d3), (d6 >= 0) & (d5 <= d6), (vc <= 0) & (d1 >= 0) & (d3 <= 0),
        (vb <= 0) & (d2 >= 0) & (d6 <= 0), (va <= 0) & (d4 >= d3) & (d5 >= d6),
    ]  # fmt: skip
    with np.errstate(all="ignore"):
        on_bc = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = np.select(cases, [zero, one, zero, d1 / (d1 - d3), zero, 1 - on_bc], vb / (va + vb + vc))
        u = np.select(cases, [zero, zero, one, zero, d2 / (d2 - d6), on_bc], vc / (va + vb + vc))
    return np.stack([1 - v - u, v, u], axis=1)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("mc,mc->m", a, b)
