"""Regions of a body's surface, which are stepped only while something moves in them or beside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints, distinct
from ..mesh.curve import along_curve
from .estimate import spread_on
from .model import Model

FEWEST, MOST = 2, 32  # eights of vertices in a region, for eight are stepped at a time: it is half a halo wide
HALO = 0.5  # of the spread of a dent, and
LEAST_EDGES = 2.0  # mean edges: so far round what moves all is awake


@dataclass(frozen=True, slots=True, kw_only=True)
class Regions:
    """Which vertices rest and wake together.

    of: (n,) the region of each vertex; whole eights of vertices, but for the last.
    starts: (regions + 1,) and
    beside: (starts[-1],) of each region, itself and those beside it.
    slack: [m] what goes no farther within a tenth of a second is at rest.
    """

    of: Ints
    starts: Ints
    beside: Ints
    slack: float


def divide(model: Model, slack: float) -> Regions:
    """Divide a body into regions that rest while nothing near them moves by more than a slack [m]."""
    places = model.mesh.rest_positions
    of = np.empty(len(places), np.int64)
    of[np.argsort(along_curve(places), kind="stable")] = np.arange(len(places)) // vertices_of(model)
    count = int(of.max()) + 1
    ones, others = np.divmod(_near(places, of, halo_of(model)), count)
    starts = np.concatenate([[0], np.cumsum(np.bincount(ones, minlength=count))])
    return Regions(of=of, starts=starts, beside=others, slack=slack)


def halo_of(model: Model) -> float:
    """Return how far round what moves all is awake at least [m]."""
    spread = max(spread_on(each, model.mesh.size) for each in model.materials)
    return max(HALO * spread, LEAST_EDGES * float(model.springs.rest_lengths.mean()))


def vertices_of(model: Model) -> int:
    """Return how many vertices a region has."""
    across = halo_of(model) / (2 * float(model.springs.rest_lengths.mean()))
    return 8 * min(max(round(across**2 / 8), FEWEST), MOST)


def _near(places: Floats, of: Ints, width: float) -> Ints:
    """Return the pairs of regions of which vertices are less than a width [m] apart, and some more: first x regions +
    second, in order.
    """
    count = int(of.max()) + 1
    boxes = np.floor((places - places.min(axis=0)) / width).astype(np.int64) + 1
    across, along, _ = steps = _strides(boxes.max(axis=0) + 2)
    box, region = np.divmod(distinct((boxes @ steps) * count + of), count)
    found = np.zeros(0, np.int64)
    for i, j in np.ndindex(3, 3):  # of three boxes in a row the numbers follow one another
        other = box + (i - 1) * across + (j - 1) * along
        first, last = np.searchsorted(box, other - 1, "left"), np.searchsorted(box, other + 1, "right")
        many = last - first
        seconds = np.arange(many.sum()) + np.repeat(first - np.cumsum(many) + many, many)
        found = distinct(np.concatenate([found, np.repeat(region, many) * count + region[seconds]]))
    return found


def _strides(size: Ints) -> Ints:
    return np.array([size[1] * size[2], size[2], 1])
