"""How many times faster than its fingertips go a body may be simulated: as often as they are slower than it answers.

Fingertips that are slow press a body through shapes in which it would rest. Moved n times faster they press it through
the same ones, so a frame takes 1/n of the steps, and what inertia and damping add is n times as much. At a speed v a
vertex of mass m, held by a stiffness k and damped by c, lags behind its place of rest by no more than

    v tau,   tau = sqrt(m / k) + c / k

(the free answer to a jump of v, and the lag of a steady motion), and the force by that share of the press' depth. All
else that holds a vertex (neighbours, a fill, what lies beyond a knee) lets it answer sooner. `dev.py core
slow-presses` measures it. k is the least secant stiffness within the depth: a bed of many pieces may be level here and
there, and its neighbours hold a vertex then.
"""

from __future__ import annotations

import math

import numpy as np

from ..body.model import Model
from .grading import Pressed

SHARE = 0.5  # of the tolerance of the force: where a fingertip starts or stops at once, it is twice as far off
MOST = 8  # times: two ticks are then left of 1/120 s, between two looks at the fingertips
DEEP = 0.5  # of the radius: errors are shares of the force that a press has which is so deep, as those of proxies are
LOOKS = 8  # displacements at which the stiffness of a bed with many pieces is looked at
SETTLING = 0.25  # [s] a body is simulated in its own time after a motion that was not slow


def times_faster(model: Model, pressed: Pressed, tolerance: float, force_tolerance: float) -> tuple[int, float]:
    """Return how many times faster than its fingertips a body may be simulated, 1 where it may not, and the share of
    the force that this may cost.

    Args:
        tolerance: of the surface [m].
        force_tolerance: as a share.
    """
    depth, lag = min(pressed.depth, DEEP * pressed.radius), pressed.speed * answer_time(model, pressed.depth)
    if not (depth > 0 and 0 < lag < math.inf):
        return 1, 0.0
    faster = min(int(min(tolerance, SHARE * force_tolerance * depth) / lag), MOST)
    return (faster, faster * lag / depth) if faster > 1 else (1, 0.0)


def answer_time(model: Model, depth: float) -> float:
    """Return the longest time tau [s] in which a vertex answers within a depth [m], infinite where nothing holds it."""
    law, moves = model.matching, model.inverse_mass > 0
    if model.free or model.rigged or model.law_set == "paper" or not (moves.any() and depth > 0):
        return math.inf
    softest = np.full(len(model.mass), np.inf)
    for d in depth * np.arange(1, LOOKS + 1) / LOOKS:
        force = law.k1 * np.minimum(d, law.d0) + law.k2 * np.maximum(d - law.d0, 0.0)
        softest = np.minimum(softest, force / d)
    if not softest[moves].min() > 0:
        return math.inf
    return float((np.sqrt(model.mass / softest) + law.damping / softest)[moves].max())
