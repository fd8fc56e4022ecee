"""TR-BDF2: trapezoid to g dt, then the two-step backward formula to dt. Second order, and it damps stiff modes.

With g = 2 - sqrt(2) both stages are backward Euler steps of the same size h = g dt / 2 from known states:

    trapezoid  v_g = v0 + h a0 + h a_g,   x_g = x0 + h v0 + h v_g
    backward   y_1 = (1 + w) y_g - w y_0 + h y_1',   w = (1 - g)^2 / (g (2 - g)) = (sqrt(2) - 1) / 2

Source: Bank et al. 1985; Hosea and Shampine 1996.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.contact import Touch
from ..reference.ticks import moved_back
from .implicit import run_implicit
from .newton import pressed, solve

STAGE = 1 - math.sqrt(0.5)  # h / dt
WEIGHT = (math.sqrt(2) - 1) / 2  # w


def advance(model: Model, state: State, touches: Sequence[Touch], dt: float) -> Floats:
    """Advance a state in place by dt [s] and return the impulses (k, 3) [N s] on the fingertips."""
    h = STAGE * dt
    x0, v0 = state.positions.copy(), state.velocities.copy()
    a0, force_0 = pressed(model, state, moved_back(touches, dt))
    force_g = solve(model, state, moved_back(touches, dt - 2 * h), x0 + h * v0, v0 + h * a0, h)
    x_base = (1 + WEIGHT) * state.positions - WEIGHT * x0
    force_1 = solve(model, state, touches, x_base, (1 + WEIGHT) * state.velocities - WEIGHT * v0, h)
    return h * ((1 + WEIGHT) * (force_0 + force_g) + force_1)


run = partial(run_implicit, advance)
