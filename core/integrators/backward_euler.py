"""Backward Euler: the forces at the end of the step. Stable at any step, and it damps what it cannot follow."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from ..base import Floats
from ..laws.contact import Touch
from ..model import Model, State
from .newton import run_implicit, solve


def advance(model: Model, state: State, touches: Sequence[Touch], dt: float) -> Floats:
    """Advance a state in place by dt [s] and return the impulses (k, 3) [N s] on the fingertips."""
    return dt * solve(model, state, touches, state.positions.copy(), state.velocities.copy(), dt)


run = partial(run_implicit, advance)
