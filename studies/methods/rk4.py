"""The classical Runge-Kutta method: four evaluations a step, fourth order where the motion is smooth."""

from __future__ import annotations

from functools import partial

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.ticks import acceleration_of, run_ticks


def advance(model: Model, state: State, dt: float, _acceleration: Floats | None = None) -> None:
    """Advance a state in place by dt [s]."""
    x, v = state.positions, state.velocities
    x0, v0 = x.copy(), v.copy()
    a1 = acceleration_of(model, state)
    x[:], v[:] = x0 + dt / 2 * v0, v0 + dt / 2 * a1
    v2, a2 = v.copy(), acceleration_of(model, state)
    x[:], v[:] = x0 + dt / 2 * v2, v0 + dt / 2 * a2
    v3, a3 = v.copy(), acceleration_of(model, state)
    x[:], v[:] = x0 + dt * v3, v0 + dt * a3
    v4, a4 = v.copy(), acceleration_of(model, state)
    x[:] = x0 + dt / 6 * (v0 + 2 * v2 + 2 * v3 + v4)
    v[:] = v0 + dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


run = partial(run_ticks, advance)
