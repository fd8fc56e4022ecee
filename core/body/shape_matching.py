"""Shape matching: Eq. (1) spread over the surface.

Each vertex is held to its place in the shape at rest by a two-piece law in its displacement u, |u| = d:

    f = k1 d up to d0, then k1 d0 + k2 (d - d0),   E = k1 d^2 / 2 + (k2 - k1) max(d - d0, 0)^2 / 2

A tension t joins the displacements of neighbours, so that a dent has a width (the spread) of its own:

    f_i = sum_j t_ij (u_j - u_i),   E = sum over edges of t |u_i - u_j|^2 / 2

t = T w, w the cotangent weights of the surface at rest: the energy T/2 of the squared gradient of u, on any mesh.
Source: Pinkall and Polthier 1993.

The shape at rest follows the best-fit rigid motion of the body (polar decomposition, weighted by k1 and t), or the
pins. For the linear part the best fit is the minimum of the energy, so net force and torque vanish by themselves; what
the second piece and the damping add is removed exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints, sums_at
from ..constants import TINY
from ..mesh.surface import Mesh

Pose = tuple[Floats, Floats]  # rotation (3, 3), translation (3,)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeMatching:
    """Shape matching of a body, vertex by vertex.

    rest: places at rest (3, n) [m].
    k1, k2: stiffness up to the knee and beyond it (n,) [N/m].
    d0: displacement at the knee (n,) [m].
    damping: (n,) [N s/m].
    mass: (n,) [kg], for rigid motion.
    pairs: (m, 2) neighbours that a tension joins.
    tension: (m,) t of theirs [N/m].
    pull: (3, n) sum_j t_ij (r_j - r_i) over the places at rest [N].
    rate: (3, n) how fast the places at rest move [m/s], None where they do not.
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
    rate: Floats | None = None


def build_shape_matching(
    mesh: Mesh,
    *,
    k1: Floats,
    k2: Floats,
    d0: Floats,
    damping: Floats,
    mass: Floats,
    tension: Floats,
) -> ShapeMatching:
    """Build the shape matching of a mesh; the arguments are the fields of ShapeMatching."""
    x = np.array(mesh.rest_positions.T, order="C")
    return ShapeMatching(
        rest=x, k1=k1, k2=k2, d0=d0, damping=damping, mass=mass, pairs=mesh.springs, tension=tension,
        pull=tension_force(mesh.springs, tension, x),
    )  # fmt: skip


def tension_force(pairs: Ints, tension: Floats, u: Floats) -> Floats:
    """Return sum_j t_ij (u_j - u_i), (3, n) [N], for displacements (3, n) [m]."""
    i, j = pairs.T
    pulls = (tension * (x[j] - x[i]) for x in u)
    return np.stack([sums_at(i, pull, u.shape[1]) - sums_at(j, pull, u.shape[1]) for pull in pulls])


def fit_pose(rest: Floats, x: Floats, weight: Floats, pull: Floats | None = None) -> Pose:
    """Return the rigid motion that brings rest (3, n) nearest to x (3, n) in weighted least squares (Kabsch).

    Args:
        pull: of a tension, (3, n) [N], where the differences between neighbours count as well.
    """
    total = weight.sum()
    c0, c1 = rest @ weight / total, x @ weight / total
    spread = ((x - c1[:, None]) * weight) @ (rest - c0[:, None]).T
    if pull is not None:
        spread -= (x - c1[:, None]) @ pull.T
    if not np.isfinite(spread).all():  # blown up: the session looks after that
        return np.full((3, 3), np.nan), np.full(3, np.nan)
    u, _, vt = np.linalg.svd(spread)
    rotation = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return rotation, c1 - rotation @ c0


def pose_of(law: ShapeMatching, x: Floats, pose: Pose | None) -> Pose:
    """Return the pose of the shape at rest: the given one, or the best fit to x."""
    return fit_pose(law.rest, x, law.k1, law.pull) if pose is None else pose


def carried_pose(rest: Floats, here: Floats, there: Floats, *, tick: float, substeps: int) -> tuple[Pose, Pose]:
    """Return the pose of a shape whose pins go from here to there (3, p) in a tick [s], and how fast it changes.

    Over the tick it stands where the substeps begin on average: so the body neither leads nor lags.
    """
    weight = np.ones(rest.shape[1])
    (turned, moved), (turns, moves) = fit_pose(rest, here, weight), fit_pose(rest, there, weight)
    turn, move, share = turns - turned, moves - moved, (1 - 1 / substeps) / 2
    return (turned + share * turn, moved + share * move), (turn / tick, move / tick)


def energy(law: ShapeMatching, x: Floats, pose: Pose | None = None) -> float:
    """Return the energy [J] at positions (3, n)."""
    rotation, translation = pose_of(law, x, pose)
    u = x - rotation @ law.rest - translation[:, None]
    d, (i, j) = np.linalg.norm(u, axis=0), law.pairs.T
    bed = float((law.k1 * d**2 + (law.k2 - law.k1) * np.maximum(d - law.d0, 0) ** 2).sum())
    return (bed + float(law.tension @ ((u[:, i] - u[:, j]) ** 2).sum(axis=0))) / 2


def force(
    law: ShapeMatching, x: Floats, v: Floats | None = None, pose: Pose | None = None, pose_rate: Pose | None = None
) -> Floats:
    """Return the forces (3, n) [N]; without a given pose the body is free and they have no net force or torque.

    Args:
        pose_rate: how fast the given pose changes [1/s], [m/s]; damping is against the shape at rest as it moves.
    """
    rotation, translation = pose_of(law, x, pose)
    u = x - rotation @ law.rest - translation[:, None]
    f = tension_force(law.pairs, law.tension, u) - secant(law, u) * u
    if v is not None:
        moving = shape_velocity(law, pose_rate) if pose is not None else rigid_velocity(law.mass, x, v)
        if law.rate is not None:
            moving = moving + rotation @ law.rate
        f -= law.damping * (v - moving)
    if pose is None:
        f -= law.mass * rigid_velocity(law.mass, x, f / law.mass)
    return f


def shape_velocity(law: ShapeMatching, pose_rate: Pose | None) -> Floats | float:
    """Return the velocities (3, n) [m/s] of the places in the shape at rest, 0 where pins do not move it."""
    return 0.0 if pose_rate is None else pose_rate[0] @ law.rest + pose_rate[1][:, None]


def rigid_velocity(mass: Floats, x: Floats, v: Floats) -> Floats:
    """Return the rigid part (3, n) of a velocity field: the one with the same linear and angular momentum."""
    total = mass.sum()
    r = x - (x @ mass / total)[:, None]
    mean = v @ mass / total
    momentum = np.cross(r, v - mean[:, None], axis=0) @ mass
    inertia = np.eye(3) * (mass * r * r).sum() - (mass * r) @ r.T
    # a straight line of vertices has no inertia about itself
    spin = np.linalg.pinv(inertia, hermitian=True) @ momentum
    return mean[:, None] + np.cross(spin[:, None], r, axis=0)


def secant(law: ShapeMatching, u: Floats) -> Floats:
    """Return how stiff each vertex is (n,) [N/m] from its place at rest to a displacement u (3, n) [m]."""
    d = np.maximum(np.sqrt((u * u).sum(axis=0)), TINY)
    k: Floats = law.k1 + (law.k2 - law.k1) * np.maximum(1 - law.d0 / d, 0)
    return k
