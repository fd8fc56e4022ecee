"""Explicit Euler: the old velocity moves the positions. Every step adds energy; it is here to show that failure."""

from __future__ import annotations

from functools import partial

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.ticks import acceleration_of, run_ticks


def advance(model: Model, state: State, dt: float, _acceleration: Floats | None = None) -> None:
    """Advance a state in place by dt [s]."""
    a = acceleration_of(model, state)
    state.positions += dt * state.velocities
    state.velocities += dt * a


run = partial(run_ticks, advance)
