"""Shape matching: Eq. (1) distributed over the surface.

A two-piece law in the displacement u, |u| = d, holds each vertex at its place in the shape at rest:

    f = k1 d up to d0, then k1 d0 + k2 (d - d0),   E = k1 d^2 / 2 + (k2 - k1) max(d - d0, 0)^2 / 2

A tension t couples the displacements of neighbours, which gives a dent its width, the spread:

    f_i = sum_j t_ij (u_j - u_i),   E = sum over edges of t |u_i - u_j|^2 / 2

With t = T w, w the cotangent weights of the surface at rest, E is T/2 times the squared gradient of u on any mesh.
Source: Pinkall and Polthier 1993.

The shape at rest follows the pins, or the best-fit rigid motion of a free body (polar decomposition, weighted by k1 and
t). For the first piece this fit minimizes the energy, so that net force and torque vanish; those of the second piece
and of the damping are removed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints, sums_at
from ..constants import TINY

Pose = tuple[Floats, Floats]  # rotation (3, 3), translation (3,)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeMatching:
    """The shape matching of a body.

    rest: places at rest (3, n) [m].
    k1, k2: stiffness up to the knee and beyond it (n,) [N/m].
    d0: displacement at the knee (n,) [m].
    damping: (n,) [N s/m].
    mass: (n,) [kg], for rigid motion.
    pairs: (m, 2) neighbours that a tension couples.
    tension: (m,) their t [N/m].
    pull: (3, n) sum_j t_ij (r_j - r_i) of the places at rest [N].
    """

    rest: Floats
    k1: Floats
    k2: Floats
    d0: Floats
    damping: Floats
    mass: Floats
    pairs: Ints
    tension: Floats
    pull: Floats


def tension_force(pairs: Ints, tension: Floats, u: Floats) -> Floats:
    """Return sum_j t_ij (u_j - u_i), (3, n) [N], for displacements (3, n) [m]."""
    i, j = pairs.T
    pulls = (tension * (x[j] - x[i]) for x in u)
    return np.stack([sums_at(i, pull, u.shape[1]) - sums_at(j, pull, u.shape[1]) for pull in pulls])


def fit_pose(rest: Floats, x: Floats, weight: Floats, pull: Floats | None = None) -> Pose:
    """Return the rigid motion that maps rest (3, n) to x (3, n) with the least weighted squares (Kabsch).

    Args:
        pull: of a tension (3, n) [N], if the differences between neighbours count as well.
    """
    total = weight.sum()
    c0, c1 = rest @ weight / total, x @ weight / total
    spread = ((x - c1[:, None]) * weight) @ (rest - c0[:, None]).T
    if pull is not None:
        spread -= (x - c1[:, None]) @ pull.T
    if not np.isfinite(spread).all():  # diverged: the session handles it
        return np.full((3, 3), np.nan), np.full(3, np.nan)
    u, _, vt = np.linalg.svd(spread)
    rotation = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return rotation, c1 - rotation @ c0


def force(law: ShapeMatching, x: Floats, pose: Pose) -> Floats:
    """Return the forces (3, n) [N], without damping, at positions (3, n) [m] and a pose of the shape at rest."""
    u = displacements(law, x, pose)
    return tension_force(law.pairs, law.tension, u) - secant(law, u) * u


def displacements(law: ShapeMatching, x: Floats, pose: Pose) -> Floats:
    """Return the displacements (3, n) [m] of vertices at x (3, n) from their places in the shape at rest."""
    rotation, translation = pose
    return x - rotation @ law.rest - translation[:, None]


def secant(law: ShapeMatching, u: Floats) -> Floats:
    """Return the secant stiffness of each vertex (n,) [N/m] at displacements u (3, n) [m]."""
    d = np.maximum(np.sqrt((u * u).sum(axis=0)), TINY)
    k: Floats = law.k1 + (law.k2 - law.k1) * np.maximum(1 - law.d0 / d, 0)
    return k
