"""A staircase: the next level from the answers so far. One up, one down: it goes round the point of equality.

Two run interleaved, one from above and one from below, so that nobody can count steps; each step is a share of the
level, halved at the first two turns, and levels within it are drawn at random so that the slope is seen too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

TURNS: Final = 2  # after which the step stays
SPREAD: Final = (-2.0, -1.0, 0.0, 1.0, 2.0)  # steps beside the track: one level alone says nothing of the slope


def next_level(start: float, step: float, answers: Sequence[tuple[float, bool]]) -> float:
    """Return the factor on the stiffness of the next trial.

    Args:
        start: of the track from above; that from below begins at 1 / start.
        step: share of the level.
        answers: level and whether it was judged the stiffer, of all trials so far.
    """
    number = len(answers)
    track = answers[number % 2 :: 2]
    level, size, turns, before = (start, 2.0 * step, 0, None) if number % 2 == 0 else (1 / start, 2.0 * step, 0, None)
    for _, stiffer in track:
        if before is not None and stiffer is not before:
            turns += 1
            size = max(size / 2, step / 2) if turns <= TURNS else size
        level *= (1 - size) if stiffer else 1 / (1 - size)
        before = stiffer
    beside = SPREAD[(number // 2) % len(SPREAD)] if turns >= TURNS else 0.0
    return round(min(max(level * (1 + beside * step), 0.05), 20.0), 4)
