"""A hand for who tries the emulated device: three fingers that poke, one after the other."""

from __future__ import annotations

import json

APART, ABOVE, BELOW = 0.015, 0.010, -0.012  # [m] from the middle, and of the middle of the workspace
BEGIN, MOVE, HOLD, EVERY, MINUTES = 1.5, 0.25, 0.5, 1.5, 5  # [s], and how long it goes on
SIDES = ((-1.0, 0.0), (0.5, -0.866), (0.5, 0.866))  # of their blocks


def poking_hand() -> str:
    """Return the hand, as `hand.load_hand` reads it: each finger in turn goes down, holds, goes up."""
    tips = []
    for i, (x, y) in enumerate(SIDES):
        at = [APART * x, APART * y]
        keys = [[0.0, *at, ABOVE]]
        for start in range(int(MINUTES * 60 / (3 * EVERY))):
            begin = BEGIN + EVERY * (3 * start + i)
            for time, z in ((0.0, ABOVE), (MOVE, BELOW), (MOVE + HOLD, BELOW), (2 * MOVE + HOLD, ABOVE)):
                keys.append([begin + time, *at, z])
        tips.append(keys)
    return json.dumps({"tips": tips})
