"""Solve the equation of an implicit step: Newton's method, each direction by preconditioned conjugate gradients.

    v = v_base + h M^-1 f(x_base + h v, v)

Every implicit method here is one or two such solves; they differ in x_base, v_base and h.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from core.base import Floats, sums_at
from core.body.model import Model
from studies.reference.laws import State

from ..reference.contact import Touch
from ..reference.ticks import acceleration_of
from . import penalty
from .cached import kept
from .penalty import Meeting
from .tangent import Tangent, tangent

NEWTON_STEPS = 30
NEWTON_TOLERANCE = 1e-8  # of the velocity
ROUNDING = 1e-12  # of what the forces at the start would do in the step: they are not known better
SPEED_FLOOR = 1e-9  # [m/s] a body at rest is solved when it is this still
CG_STEPS = 300
CG_TOLERANCE = 1e-2  # of the residual: a better direction does not pay
HALVINGS = 12
CONTACT_STIFFNESS = 30.0  # of what holds a vertex: a fingertip sinks in by well under a hundredth of its radius


def what_holds(model: Model) -> Floats:
    """Return how stiffly springs and shape matching hold each vertex (n,) [N/m]."""
    law, along = model.matching, model.springs.stiffness + model.matching.tension
    return sums_at(law.pairs.ravel(), np.repeat(along, 2), len(model.mass)) + np.maximum(law.k1, law.k2)


def meet_faces(model: Model, state: State, touches: Sequence[Touch], share: float = CONTACT_STIFFNESS) -> list[Meeting]:
    """Find what the fingertips press at a state; share: stiffness of a face over what holds a vertex."""
    if not touches:
        return []
    stiffness = share * kept(model, what_holds)
    return [penalty.meeting(state.positions, touch, stiffness, model.matching.rest) for touch in touches]


def pressed(model: Model, state: State, touches: Sequence[Touch]) -> tuple[Floats, Floats]:
    """Return the acceleration (3, n) [m/s2] with contact, and the forces (k, 3) [N] on the fingertips."""
    a, met = acceleration_of(model, state), meet_faces(model, state, touches)
    for m in met:
        a += penalty.force(m, a.shape[1]) * model.inverse_mass
    return a, np.array([m.reaction for m in met]).reshape(-1, 3)


def solve(
    model: Model,
    state: State,
    touches: Sequence[Touch],
    x_base: Floats,
    v_base: Floats,
    h: float,
    *,
    tolerance: float = NEWTON_TOLERANCE,
    drop: float = ROUNDING,
) -> Floats:
    """Put a state, in place, at x_base + h v, v; where no v solves the equation, count it in state.unsolved.

    Args:
        tolerance: residual over the velocity.  drop: residual over that of the velocity at the start, if more.

    Returns:
        the forces (k, 3) [N] on the fingertips there.
    """  # fmt: skip
    weight = np.where(model.inverse_mass > 0, model.mass, 0.0)

    def residual(v: Floats) -> Floats:
        state.positions[:], state.velocities[:] = x_base + h * v, v
        return v_base + h * pressed(model, state, touches)[0] - v

    def norm(r: Floats) -> float:
        return float(np.sqrt(((r * r) @ weight).sum()))

    v = state.velocities.copy()  # v_base may throw a stiff body far away
    r = residual(v)
    size = norm(r)
    floor = norm(v_base) * tolerance + size * drop + SPEED_FLOOR * float(np.sqrt(weight.sum()))
    for _ in range(NEWTON_STEPS):
        if size <= floor + tolerance * norm(v):
            break
        system = tangent(model, state, h, meet_faces(model, state, touches))
        direction = conjugate_gradients(system, r * weight)
        slope = float((direction * r).sum(axis=0) @ weight)
        for halving in range(HALVINGS):
            share = 0.5**halving
            ahead = residual(v + share * direction)
            # closer, or still downhill all the way there
            if norm(ahead) < size or float((direction * ahead).sum(axis=0) @ weight) > 0.5 * slope:
                break
        else:
            break
        v = v + share * direction
        r, size = ahead, norm(ahead)
    if not size <= floor + tolerance * norm(v):
        residual(v)
        state.unsolved += 1
    return pressed(model, state, touches)[1]


def conjugate_gradients(system: Tangent, b: Floats) -> Floats:
    """Solve A s = b (3, n) to CG_TOLERANCE; stop at a direction along which A is not positive."""
    s = np.zeros_like(b)
    r = b.copy()
    z = system.precondition(r)
    p = z
    rz = float((r * z).sum())
    goal = CG_TOLERANCE**2 * rz
    for _ in range(CG_STEPS):
        q = system.product(p)
        curvature = float((p * q).sum())
        if curvature <= 0:
            return s if s.any() else z
        step = rz / curvature
        s += step * p
        r -= step * q
        z = system.precondition(r)
        rz, before = float((r * z).sum()), rz
        if rz <= goal:
            break
        p = z + rz / before * p
    return s
