"""Backward Euler: the forces at the end of the step. Stable at any step; it damps modes too fast for it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.contact import Touch
from .implicit import run_implicit
from .newton import solve


def advance(model: Model, state: State, touches: Sequence[Touch], dt: float) -> Floats:
    """Advance a state in place by dt [s] and return the impulses (k, 3) [N s] on the fingertips."""
    return dt * solve(model, state, touches, state.positions.copy(), state.velocities.copy(), dt)


run = partial(run_implicit, advance)
