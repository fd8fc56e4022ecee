"""What of a full mesh moves under one fingertip: the rest of it rests, and costs nothing.

A dent falls off beyond the fingertip as the modified Bessel function K0(r / l), l being the spread of the material. So
what goes farther than a slack s in a press of depth d lies within about

    radius / 2 + l (ln(d / s) - 1)

of its centre. What is awake round that, and the size of regions, come on top. A liquid moves all of the surface, and
what has a weight or a pressure to begin with first settles as a whole. `dev.py core regions` measures it.
"""

from __future__ import annotations

import math

from ..body.model import Model
from ..body.regions import halo_of, vertices_of
from ..material import KEEP_VOLUME
from .error_model import spread_of

SLACK = 0.2  # of the tolerance of the surface, and
OF_RADIUS = 0.01  # of the fingertip's radius: what goes no farther is at rest
DEEP = 0.5  # of the radius: how deep the press is that costs are of
BOXES = 1.5  # halos: as far is awake round what moves, in the mean
MORE = 1.25  # times: presses scatter about the estimate


def slack_of(tolerance: float, radius: float) -> float:
    """Return how far something may go and be at rest [m], for a tolerance [m] and a fingertip's radius [m]."""
    return min(SLACK * tolerance, OF_RADIUS * radius)


def may_rest(model: Model) -> bool:
    """Tell whether parts of a body can rest while others are pressed."""
    pushed = model.pressure.rest_pressure or model.gravity.any() or model.ground is not None
    holds = model.matching.k1.any() and not model.free and not model.rigged
    return bool(holds and not pushed) and model.pressure.fill not in KEEP_VOLUME


def share_awake(model: Model, radius: float, slack: float) -> float:
    """Return about which share of the vertices is stepped while one fingertip of a radius [m] presses."""
    moves = radius / 2 + spread_of(model) * max(math.log(max(DEEP * radius / slack, 1.0)) - 1, 0.0)
    across = math.sqrt(vertices_of(model)) * float(model.mesh.rest_lengths.mean())
    reach = moves + BOXES * halo_of(model) + 2 * across
    return min(MORE * math.pi * reach**2 / float(model.mesh.triangle_areas.sum()), 1.0)
