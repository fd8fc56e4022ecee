"""The native core as one of the methods: it advances a state along a path as the others do."""

from __future__ import annotations

import numpy as np

from core import native
from core.base import Floats
from core.body.model import Model
from core.native.motion import Motion
from studies.motions import straight
from studies.reference.laws import State

from ..reference.path import FingerPath

KEPT = 8  # bodies
EVEN = 1e-12  # [m] how far ticks of an even motion may differ


def run(model: Model, state: State, path: FingerPath, *, tick: float, substeps: int, bits: int = 64) -> Floats:
    """Advance a state in place in double precision and return the impulses (k, 3) [N s] on the fingertips."""
    body = body_of(model, bits)
    body.set_state(state.positions, state.velocities)
    total, pieces = np.zeros((len(path.radii), 3)), _even_pieces(path.centres)
    for first, last in zip(pieces, pieces[1:], strict=False):
        tips = tuple(
            straight(a.tolist(), b.tolist(), ticks=last - first, radius=float(r), fresh=first == 0)
            for a, b, r in zip(path.centres[:, first], path.centres[:, last], path.radii, strict=True)
        )
        frame = body.step(Motion(last - first, substeps, tick, tips))
        if not frame.finite:
            state.positions[:] = np.nan
            return total
        total += np.array([touch.impulse for touch in frame.touches if touch]).reshape(-1, 3)
    state.positions[:], state.velocities[:] = body.positions(), body.velocities()
    state.volume, state.pressure = frame.volume, frame.pressure
    return total


def body_of(model: Model, bits: int) -> native.Body:
    """Return the body of a model, made at its first use; the last few are kept."""
    key = id(model), bits  # a body that is kept keeps its model, so its id is not another's
    if key not in _bodies:
        while len(_bodies) >= KEPT:
            del _bodies[next(iter(_bodies))]
        _bodies[key] = native.Body(model, native.library(), bits=bits)
    return _bodies[key]


def _even_pieces(centres: Floats) -> list[int]:
    """Return the ticks at which fingertips (k, ticks + 1, 3) change their velocity, with the first and the last."""
    ticks = centres.shape[1] - 1
    change = np.abs(np.diff(centres, n=2, axis=1)).max(axis=(0, 2), initial=0.0) > EVEN
    return [0, *(np.flatnonzero(change) + 1).tolist(), ticks]


_bodies: dict[tuple[int, int], native.Body] = {}
