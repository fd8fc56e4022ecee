"""Implicit midpoint: half a step of backward Euler, then the same displacement again. It keeps the energy of a mode."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.contact import Touch
from ..reference.ticks import moved_back
from .implicit import run_implicit
from .newton import solve


def advance(model: Model, state: State, touches: Sequence[Touch], dt: float) -> Floats:
    """Advance a state in place by dt [s] and return the impulses (k, 3) [N s] on the fingertips."""
    x0, v0 = state.positions.copy(), state.velocities.copy()
    force = solve(model, state, moved_back(touches, dt / 2), x0, v0, dt / 2)
    state.positions[:] = 2 * state.positions - x0
    state.velocities[:] = 2 * state.velocities - v0
    return dt * force


run = partial(run_implicit, advance)
