"""The points of triangles that are nearest to others."""

from __future__ import annotations

import numpy as np

from ..base import Floats


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
