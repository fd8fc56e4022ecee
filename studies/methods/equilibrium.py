"""Where a body comes to rest under still fingertips: a quasi-static solver, what methods are compared with.

Backward Euler from standstill minimises E(x) + M |x - x0|^2 / (2 h^2). Steps that grow to a large h so lead downhill
in energy to an equilibrium, however far it is, and the last ones converge as Newton's method does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.base import DimpleError, Floats
from core.body.model import Model, State, initial_state

from ..reference.contact import Touch
from .newton import pressed, solve

FIRST_STEP = 0.01  # [s]
LAST_STEP = 1e4  # [s] beyond it mass no longer counts
GROWTH = 10.0
STEPS = 40
LOOSE = 1e-3  # how well a step on the way is solved
FORCE_FLOOR = 1e-3  # [N] a body nobody presses is at rest to the tolerance times this


@dataclass(frozen=True, slots=True, kw_only=True)
class Equilibrium:
    """A body at rest.

    positions: (3, n) [m].  reactions: (k, 3) on the fingertips [N].  residual: unbalanced force, root of the sum of
    squares [N].  steps: proximal steps taken.  converged: whether the residual met the tolerance.
    """

    positions: Floats
    reactions: Floats
    residual: float
    steps: int
    converged: bool


def spheres(model: Model, centres: Floats, radii: Floats) -> list[Touch]:
    """Return still fingertips: centres (k, 3) [m], radii (k,) [m]; each may meet any face."""
    movable = model.mesh.triangles[(model.inverse_mass[model.mesh.triangles] > 0).any(axis=1)]
    nobody = np.zeros(0, np.int64)
    return [
        Touch(
            centre=c, velocity=np.zeros(3), radius=float(r), vertices=nobody, triangles=movable,
            radii=np.full(len(movable), float(r)),
        )  # fmt: skip
        for c, r in zip(np.reshape(centres, (-1, 3)), radii, strict=True)
    ]


def equilibrium(
    model: Model, touches: Sequence[Touch], *, start: Floats | None = None, tolerance: float = 1e-4
) -> Equilibrium:
    """Find where a body rests, pressed by still fingertips without friction.

    Args:
        touches: from `spheres`.
        start: (3, n) [m], the shape at rest when left out. A skin that lies beyond a fingertip's centre at the start
            has let it through: go deeper in steps of less than its radius, each from the one before.
        tolerance: unbalanced force over the sum of the reactions.

    Returns:
        the equilibrium downhill from the start; `converged` is False where STEPS did not reach it.

    Raises:
        DimpleError: there is a ground plane, which is not solved for.
    """
    if model.ground is not None:
        raise DimpleError("An equilibrium needs a body without a ground plane.")
    state = initial_state(model)
    if start is not None:
        state.positions[:] = start
    h, steps, still = FIRST_STEP, 0, np.zeros_like(state.positions)
    reactions, residual, goal = _balance(model, state, touches, tolerance)
    while residual > goal and steps < STEPS:
        before, unsolved = state.positions.copy(), state.unsolved
        solve(model, state, touches, before, still, h, drop=LOOSE)
        found = _balance(model, state, touches, tolerance)
        steps += 1
        if not np.isfinite(found[1]) or state.unsolved > unsolved and found[1] > residual:
            state.positions[:] = before
            h /= GROWTH
            continue
        reactions, residual, goal = found
        h = min(h * GROWTH, LAST_STEP)
    return Equilibrium(
        positions=state.positions, reactions=reactions, residual=residual, steps=steps, converged=residual <= goal
    )


def _balance(model: Model, state: State, touches: Sequence[Touch], tolerance: float) -> tuple[Floats, float, float]:
    """Return the reactions (k, 3), the unbalanced force and the one allowed [N]."""
    state.velocities[:] = 0
    a, reactions = pressed(model, state, touches)
    residual = float(np.sqrt(((a * model.mass) ** 2).sum()))
    return reactions, residual, tolerance * (float(np.linalg.norm(reactions, axis=1).sum()) + FORCE_FLOOR)
