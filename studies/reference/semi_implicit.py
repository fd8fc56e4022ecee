"""Semi-implicit Euler: Eqs. (6) to (8) of the paper."""

from __future__ import annotations

from functools import partial

from core.base import Floats
from core.body.model import Model

from .laws import State
from .ticks import acceleration_of, run_ticks


def advance(model: Model, state: State, dt: float, _acceleration: Floats | None = None) -> None:
    """Advance a state in place by dt [s]: the new velocity moves the positions."""
    state.velocities += dt * acceleration_of(model, state)
    state.positions += dt * state.velocities


run = partial(run_ticks, advance)
