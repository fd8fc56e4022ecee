"""How many times faster than its fingertips go a body may be simulated: as often as they are slower than it answers.

Fingertips that are slow press a body through shapes in which it would rest. Moved k times faster they press it through
the same ones, so a frame takes 1/k of the steps, and what inertia and damping add is k times as much. At a speed v a
vertex of mass m, held by k1 and damped by c, lags behind its place of rest by no more than

    v tau,   tau = sqrt(m / k1) + c / k1

(the free answer to a jump of v, and the lag of a steady motion), and the force by that share of the press' depth. All
else that holds a vertex (neighbours, a fill, what lies beyond a knee) lets it answer sooner. `dev.py core
slow-presses` measures it.
"""

from __future__ import annotations

import math

import numpy as np

from ..body.model import Model
from .grading import Pressed

SHARE = 0.5  # of the tolerance of the force: where a fingertip starts or stops at once, it is twice as far off
MOST = 8  # times: two ticks are then left of 1/120 s, between two looks at the fingertips
DEEP = 0.5  # of the radius: errors are shares of the force that a press has which is so deep, as those of proxies are
SETTLING = 0.25  # [s] a body is simulated in its own time after a motion that was not slow


def times_faster(model: Model, pressed: Pressed, tolerance: float, force_tolerance: float) -> tuple[int, float]:
    """Return how many times faster than its fingertips a body may be simulated, 1 where it may not, and the share of
    the force that this may cost.

    Args:
        tolerance: of the surface [m].
        force_tolerance: as a share.
    """
    depth, lag = min(pressed.depth, DEEP * pressed.radius), pressed.speed * answer_time(model)
    if not (depth > 0 and 0 < lag < math.inf):
        return 1, 0.0
    faster = min(int(min(tolerance, SHARE * force_tolerance * depth) / lag), MOST)
    return (faster, faster * lag / depth) if faster > 1 else (1, 0.0)


def answer_time(model: Model) -> float:
    """Return the longest time tau [s] that a vertex takes to answer, infinite where nothing holds it."""
    law, moves = model.matching, model.inverse_mass > 0
    if model.free or model.rigged or model.law_set == "paper" or not moves.any():
        return math.inf
    stiffness = np.minimum(law.k1, law.k2) + np.minimum(law.more, 0.0).sum(axis=0)
    if not stiffness[moves].min() > 0:
        return math.inf
    return float((np.sqrt(model.mass / stiffness) + law.damping / stiffness)[moves].max())
