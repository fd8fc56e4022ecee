"""The linear system of an implicit step: A = M + h C + h^2 K, symmetric, made positive where the laws are not.

K = -df/dx, C = -df/dv. A spring under compression pushes sideways, 1 - l0/|l| < 0: that part is left out, so that
Newton's direction goes downhill. Pressure is its rank-one part g g^T (-dp/dV), never a dense matrix, and its
geometric part -p d2V/dx2. The shape at rest follows a free body, so rigid motion meets no shape matching: there K is
exact at rest, and near otherwise. tests/studies/test_tangent.py states what holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from core.base import Floats, sums_at
from core.body import pressure, shape_matching
from core.body.model import Model
from core.body.shape_matching import Pose, ShapeMatching
from studies.reference.laws import State, pose_of, rigid_velocity

from . import penalty
from .penalty import Meeting

_TINY = 1e-30
Product = Callable[[Floats], Floats]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tangent:
    """The products A s and, approximately, A^-1 r, both (3, n) -> (3, n) and 0 where pinned."""

    product: Product
    precondition: Product


def tangent(model: Model, state: State, h: float, met: Sequence[Meeting] = ()) -> Tangent:
    """Return the system of an implicit step of h [s] at a state, in contact with what was met."""
    free = model.inverse_mass > 0
    mass = np.where(free, model.mass, 1.0)
    springs_product, springs_blocks = _springs(model, state, h)
    memory_product, memory_blocks = _memory(model, state, h)
    fill_product, along, weight = _fill(model, state, h)

    def product(s: Floats) -> Floats:
        total = mass * s + springs_product(s) + memory_product(s) + fill_product(s)
        for m in met:
            total += h * h * penalty.stiffness_product(m, s)
        return free * total

    blocks = springs_blocks + memory_blocks
    blocks[:, range(3), range(3)] += mass[:, None]
    for m in met:
        blocks += h * h * penalty.stiffness_blocks(m, len(free))
    inverse = _inverse(blocks) * free[:, None, None]

    def by_blocks(r: Floats) -> Floats:
        return np.einsum("nij,jn->in", inverse, r)

    # one rank more costs one product: Sherman and Morrison
    eased = by_blocks(along)
    pull = weight / (1 + weight * float((along * eased).sum()))

    def by_rank_one(r: Floats) -> Floats:
        z = by_blocks(r)
        return z - pull * float((along * z).sum()) * eased

    def rigid(s: Floats) -> Floats:
        return free * rigid_velocity(free * mass, state.positions, s)

    def precondition(r: Floats) -> Floats:
        if state.pose is not None:
            return by_rank_one(r)
        # rigid motion meets mass alone: solved at once, or stiff modes would drown it
        moved = rigid(r / mass)
        z = by_rank_one(r - mass * moved)
        return moved + z - rigid(z)

    return Tangent(product=product, precondition=precondition)


def _inverse(blocks: Floats) -> Floats:
    """Return the inverses (n, 3, 3) of symmetric blocks (n, 3, 3), by their cofactors.

    np.linalg.inv starts OpenBLAS's threads for every block; on a busy machine that is most of a solve.
    """
    a, b, c = blocks[:, 0], blocks[:, 1], blocks[:, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    return cofactors / (a * cofactors[:, 0]).sum(axis=1)[:, None, None]


def _springs(model: Model, state: State, h: float) -> tuple[Product, Floats]:
    law, x = model.springs, state.positions
    i, j = law.pairs.T
    n = x.shape[1]
    d = x[:, j] - x[:, i]
    length = np.maximum(np.sqrt((d * d).sum(axis=0)), _TINY)
    e = d / length
    across = h * h * law.stiffness * np.maximum(1 - law.rest_lengths / length, 0)
    along = h * h * law.stiffness + h * law.damping - across

    def product(s: Floats) -> Floats:
        r = s[:, j] - s[:, i]
        pull = across * r + along * (e * r).sum(axis=0) * e
        return np.stack([sums_at(j, pull[c], n) - sums_at(i, pull[c], n) for c in range(3)])

    blocks = np.empty((n, 3, 3))
    for a in range(3):
        for b in range(a, 3):
            part = along * e[a] * e[b] + (across if a == b else 0.0)
            blocks[:, a, b] = blocks[:, b, a] = sums_at(i, part, n) + sums_at(j, part, n)
    return product, blocks


def stiffness_parts(law: ShapeMatching, x: Floats, pose: Pose) -> tuple[Floats, Floats, Floats]:
    """Return a (n,) [N/m], b (n,) [N/m3] and u (3, n) [m] of K = a + b u u^T, vertex by vertex, without the tension."""
    rotation, translation = pose
    u = x - rotation @ law.rest - translation[:, None]
    d = np.maximum(np.sqrt((u * u).sum(axis=0)), _TINY)
    turn = np.where(d > law.d0, (law.k2 - law.k1) * law.d0, 0.0)
    return shape_matching.secant(law, u), turn / d**3, u


def _memory(model: Model, state: State, h: float) -> tuple[Product, Floats]:
    law, x = model.matching, state.positions
    pose = pose_of(law, x, state.pose)
    bed, turn, u = stiffness_parts(law, x, pose)
    level, steep, tension, drag = h * h * bed, h * h * turn, h * h * law.tension, h * law.damping

    def pull(s: Floats) -> Floats:
        return level * s + steep * (u * s).sum(axis=0) * u - shape_matching.tension_force(law.pairs, tension, s)

    def rigid(s: Floats) -> Floats:
        return rigid_velocity(law.mass, x, s)

    if state.pose is None:
        relative, transposed = _relative(law, x)

        def product(s: Floats) -> Floats:
            damped = drag * (s - rigid(s))
            return transposed(pull(relative(s))) + damped - law.mass * rigid(damped / law.mass)
    else:

        def product(s: Floats) -> Floats:
            return pull(s) + drag * s

    blocks = np.einsum("n,an,bn->nab", steep, u, u)
    met = sums_at(law.pairs.ravel(), np.repeat(tension, 2), x.shape[1])
    blocks[:, range(3), range(3)] += (level + met + drag)[:, None]
    return product, blocks


def _relative(law: ShapeMatching, x: Floats) -> tuple[Product, Product]:
    """Return P, a displacement less the rigid motion with which the shape at rest follows it, and its transpose.

    The shape at rest moves to the least energy: P = 1 - R (R^T K R)^-1 R^T K, R the rigid motions (6), K of k1 and t.
    """
    arm = x - x.mean(axis=1, keepdims=True)
    arm /= max(float(np.abs(arm).max()), _TINY)
    axes = np.eye(3)[:, :, None]
    rigid = np.concatenate([axes + 0 * arm, np.cross(axes, arm[None], axis=1)])
    met = np.stack([law.k1 * r - shape_matching.tension_force(law.pairs, law.tension, r) for r in rigid])
    rigid, met = rigid.reshape(6, -1), met.reshape(6, -1)
    inverse = np.linalg.pinv(rigid @ met.T, rcond=1e-12, hermitian=True)  # a straight line has no turn about itself

    def relative(s: Floats) -> Floats:
        return s - ((inverse @ (met @ s.ravel())) @ rigid).reshape(s.shape)

    def transposed(f: Floats) -> Floats:
        return f - ((inverse @ (rigid @ f.ravel())) @ met).reshape(f.shape)

    return relative, transposed


def _fill(model: Model, state: State, h: float) -> tuple[Product, Floats, float]:
    """Return the product of the fill, its gradient g (3, n) and the weight of g g^T."""
    law, x = model.pressure, state.positions
    if not law.kind:
        return np.zeros_like, np.zeros_like(x), 0.0
    volume, g = pressure.volume_and_gradient(law, x)
    p, weight = pressure.pressure_at(law, volume), h * h * pressure.pressure_slope(law, volume)
    g = g * (model.inverse_mass > 0)

    def product(s: Floats) -> Floats:
        # dV/dx is quadratic: half the difference at x + s and x - s is exact, and best where s is as large as x
        scale = model.mesh.size / max(float(np.abs(s).max()), _TINY)
        _, ahead = pressure.volume_and_gradient(law, x + scale * s)
        _, behind = pressure.volume_and_gradient(law, x - scale * s)
        return weight * float((g * s).sum()) * g - h * h * p / (2 * scale) * (ahead - behind)

    return product, g, weight
