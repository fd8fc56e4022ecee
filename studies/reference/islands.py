"""Sleep where bodies meet: what may touch sleeps together, and wakes before anything that moves can touch it."""

from __future__ import annotations

import numpy as np

from core.base import Bools, Ints


def woken(moving: Bools, asleep: Bools, sides: Ints, free: Bools) -> list[int]:
    """Return which surfaces sleep, and may be touched by something that moves, or by what that wakes.

    Args:
        moving: (k,) which surfaces move: what is awake, and colliders that are led.
        asleep: (k,) which sleep.
        sides: (m, 2) surfaces that may touch before the next look.
        free: (k,) which sleep at times: bodies and props.
    """
    found: list[int] = np.flatnonzero(asleep & _reached(moving, sides, free)).tolist()
    return found


def let_sleep(moving: Bools, rested: Bools, sides: Ints, free: Bools) -> list[int]:
    """Return which surfaces have come to rest with all that they may touch.

    Args:
        rested: (k,) which have come to rest themselves; others as in `woken`.
    """
    found: list[int] = np.flatnonzero(rested & ~_reached(moving & ~rested, sides, free)).tolist()
    return found


def _reached(found: Bools, sides: Ints, free: Bools) -> Bools:
    """Return what is reached from some surfaces (k,), through what is free alone."""
    found = found.copy()
    sides = sides[(found[sides] | free[sides]).all(axis=1)]
    while True:
        before = int(found.sum())
        found[sides[found[sides[:, 0]], 1]] = True
        found[sides[found[sides[:, 1]], 0]] = True
        if int(found.sum()) == before:
            return found
