"""A staircase: the next level from the answers so far. One up, one down: it converges on the point of equality.

Two run interleaved, one from above and one from below, so that nobody can count steps; each step is a share of the
level, halved at each of the first two turns, and levels within it are drawn at random so that the slope is seen too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from .plan import LEAST, MOST

SPREAD: Final = (-2, -1, 0, 1, 2)  # steps beside the track after two turns: one level alone says nothing of the slope


def next_level(start: float, step: float, answers: Sequence[tuple[float, bool]]) -> float:
    """Return the factor on the stiffness of the next trial.

    Args:
        start: of the track from above; that from below begins at 1 / start.
        step: share of the level; the first steps are twice as large.
        answers: level and whether it was judged the stiffer, of all trials so far.
    """
    number = len(answers)
    level = 1 / start if number % 2 else start
    turns, before = 0, None
    for _, stiffer in answers[number % 2 :: 2]:
        turns += before is not None and stiffer is not before
        level *= (1 - 2 * step / 2 ** min(turns, 2)) ** (1 if stiffer else -1)
        before = stiffer
    beside = SPREAD[number // 2 % len(SPREAD)] if turns >= 2 else 0
    return round(min(max(level * (1 + beside * step), LEAST), MOST), 4)
