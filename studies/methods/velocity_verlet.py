"""Velocity Verlet: half a kick, a drift, half a kick.

Dashpots at the end of the step need the velocity there, v1 = v + dt/2 (a0 + a(x1, v1)). Taking v + dt a0 for it
inside a is wrong by O(dt^2), so v1 by O(dt^3) a step: the method stays of second order, and one evaluation a step
is enough. Without damping it is the usual symplectic Verlet.
"""

from __future__ import annotations

from functools import partial

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.ticks import acceleration_of, run_ticks


def advance(model: Model, state: State, dt: float, acceleration: Floats | None = None) -> Floats:
    """Advance a state in place by dt [s] and return the acceleration at its end."""
    x, v = state.positions, state.velocities
    a = acceleration_of(model, state) if acceleration is None else acceleration
    x += dt * (v + dt / 2 * a)
    v += dt * a
    after = acceleration_of(model, state)
    v += dt / 2 * (after - a)
    return after


run = partial(run_ticks, advance)
