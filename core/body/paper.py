"""The paper's model, literally: Eqs. (1) to (5), with nothing repaired.

Kept as the reference. Its limits are stated by tests/physics/test_paper_limits.py.
Source: Sakama, Tanaka and Araki, Haptic Rendering for Virtual Object in Cyber Space.
"""

from __future__ import annotations

import numpy as np

from ..base import Floats, Ints, sums_at
from .springs import Springs

_TINY = 1e-30


def contact_area(contact: Ints, triangles: Ints, x: Floats) -> float:
    """Return A_c [m2]: a third of each triangle's area for each of its corners in contact."""
    touching = np.zeros(x.shape[1])
    touching[contact] = 1
    areas = np.linalg.norm(_face_normals(triangles, x), axis=0) / 2
    return float((areas * touching[triangles].sum(axis=1)).sum()) / 3


def inner_pressure(force: float, area: float) -> float:
    """Return p = f / A_c [Pa], Eq. (2); no contact, no pressure."""
    return force / area if area > 0 else 0.0


def pressure_force(pressure: float, triangles: Ints, x: Floats, rest_area: float) -> Floats:
    """Return f_p = p (A_0 / n_0) v_n (3, n) [N], Eq. (3); v_n is the unit sum of the unit normals round a vertex."""
    normals = _face_normals(triangles, x)
    normals /= np.maximum(np.linalg.norm(normals, axis=0), _TINY)
    total = np.stack([sums_at(triangles.ravel(), np.repeat(normals[c], 3), x.shape[1]) for c in range(3)])
    return pressure * rest_area / x.shape[1] * total / np.maximum(np.linalg.norm(total, axis=0), _TINY)


def spring_force(law: Springs, x: Floats) -> Floats:
    """Return f_k = k (|l| - |l0|) l / |l0| (3, n) [N], Eq. (4), signed so that it restores."""
    i, j = law.pairs.T
    d = x[:, j] - x[:, i]
    pull = law.stiffness * (np.linalg.norm(d, axis=0) - law.rest_lengths) / np.maximum(law.rest_lengths, _TINY) * d
    n = x.shape[1]
    return np.stack([sums_at(i, pull[c], n) - sums_at(j, pull[c], n) for c in range(3)])


def _face_normals(triangles: Ints, x: Floats) -> Floats:
    a, b, c = x[:, triangles[:, 0]], x[:, triangles[:, 1]], x[:, triangles[:, 2]]
    return np.asarray(np.cross(b - a, c - a, axis=0), np.float64)
