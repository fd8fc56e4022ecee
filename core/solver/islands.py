"""Sleep where bodies meet: what may touch sleeps together, and wakes before anything that moves can touch it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import Bools, Ints
from .twin import Call, Twin


def moves(bodies: Sequence[Twin], led: Bools) -> Bools:
    """Return which surfaces move (k,): bodies that are awake, and colliders that are led."""
    return np.concatenate([[not body.rest.asleep for body in bodies], led]).astype(bool)


def woken(bodies: Sequence[Twin], led: Bools, sides: Ints) -> list[int]:
    """Return which bodies sleep, and may be touched by something that moves, or by what that wakes.

    Args:
        led: which colliders are.
        sides: (m, 2) surfaces that may touch before the next look.
    """
    reached = _reached(moves(bodies, led), sides, len(bodies))
    return [i for i, body in enumerate(bodies) if body.rest.asleep and reached[i]]


def let_sleep(bodies: Sequence[Twin], calls: Sequence[Call], led: Bools, sides: Ints) -> None:
    """Let bodies sleep that have come to rest with all that they may touch."""
    kept = np.concatenate([[not body.rest.asleep and not body.rest.rested for body in bodies], led]).astype(bool)
    kept = _reached(kept, sides, len(bodies))
    for i, (body, call) in enumerate(zip(bodies, calls, strict=True)):
        if body.rest.rested and not kept[i]:
            body.fall_asleep(call)


def _reached(found: Bools, sides: Ints, bodies: int) -> Bools:
    """Return what is reached from some surfaces (k,), through bodies alone."""
    sides = sides[(found[sides] | (sides < bodies)).all(axis=1)]
    while True:
        before = int(found.sum())
        found[sides[found[sides[:, 0]], 1]] = True
        found[sides[found[sides[:, 1]], 0]] = True
        if int(found.sum()) == before:
            return found
