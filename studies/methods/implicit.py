"""The loop that all implicit methods share: contact with fingertips is part of the equation of each step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference.contact import Touch, rest_on_ground
from ..reference.facets import faces_near
from ..reference.path import FingerPath
from ..reference.ticks import each_tick, moved_back

# advance(model, state, touches, dt): move a state in place by dt [s], fingertips to where they are at its end, and
# return the impulses (k, 3) [N s]
WITHIN = 1.5  # radii of a fingertip: what it may meet in a tick
Advance = Callable[[Model, State, Sequence[Touch], float], Floats]


def run_implicit(
    advance: Advance, model: Model, state: State, path: FingerPath, *, tick: float, substeps: int
) -> Floats:
    """Advance a state in place by the ticks [s] of a path, contact solved together with the motion.

    Returns:
        the impulses (k, 3) [N s] on the fingertips.

    Raises:
        DimpleError: the laws have no energy, so no implicit method may be used.
    """
    total = np.zeros((len(path.radii), 3))
    for near in each_tick(model, state, path, tick):
        touches = [with_all_faces(model, state, touch) for touch in near]
        for i in range(substeps):
            now = moved_back(touches, (substeps - 1 - i) * tick / substeps)
            try:
                total += advance(model, state, now, tick / substeps)
            except np.linalg.LinAlgError:  # no rigid motion fits a body that has blown up
                state.positions[:] = np.nan
                return total
            if model.ground is not None:
                x, v, dt = state.positions, state.velocities, tick / substeps
                rest_on_ground(x, v, model.ground, model.inverse_mass, model.friction, dt)
    return total


def with_all_faces(model: Model, state: State, touch: Touch) -> Touch:
    """Return a fingertip that meets small faces too: the penalty knows faces alone, no vertices."""
    near = faces_near(state.positions, model.mesh.triangles, model.inverse_mass, touch.centre, WITHIN * touch.radius)
    return replace(touch, triangles=model.mesh.triangles[near])
