"""Motion without contact, by any method or any solver of differential equations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from core.base import Floats
from core.body.model import Model
from studies.methods.registry import METHODS
from studies.reference.laws import State, initial_state
from studies.reference.path import FingerPath
from studies.reference.ticks import acceleration_of


def move(model: Model, state: State, method: str, *, seconds: float, steps: int) -> State:
    """Advance a state in place by equal steps without fingertips, and return it; what blows up ends as NaN."""
    no_fingers = FingerPath(centres=np.zeros((0, 2, 3)), radii=np.zeros(0))
    with np.errstate(all="ignore"):
        METHODS[method].run(model, state, no_fingers, tick=seconds, substeps=steps)
    return state


def right_hand_side(model: Model) -> Callable[[float, Floats], Floats]:
    """Return y' = f(t, y) for y = (positions, velocities), flat (6 n,): the form that solvers from elsewhere take."""
    state = initial_state(model)
    half = state.positions.size

    def slope(_time: float, y: Floats) -> Floats:
        state.positions[:] = y[:half].reshape(3, -1)
        state.velocities[:] = y[half:].reshape(3, -1)
        return np.concatenate([y[half:], acceleration_of(model, state).ravel()])

    return slope


def relative_error(found: Floats, wanted: Floats, start: Floats) -> float:
    """Return the distance of two sets of positions over the distance wanted from the start (all alike, [m])."""
    return float(np.linalg.norm(found - wanted) / np.linalg.norm(wanted - start))
