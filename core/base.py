"""The vocabulary of the core: units, named tolerances, and the one error an artist sees.

Everything in `core` is SI: metres, kilograms, seconds, newtons, pascals.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from .errors import LARGEST as LARGEST
from .errors import DimpleError as DimpleError  # a module of its own, so that the servo process needs no numpy

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Shorts = npt.NDArray[np.uint16]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

LEAST_VOLUME_OPEN = 1e-2  # of size x area, in an open mesh: a crumpled sheet encloses none, a hemisphere has 0.17
MASS_FLOOR = 1e-2  # of the mean: no vertex is lighter
STIFFEST = 4.0  # of the median stiffness over mass: the vertex of a sliver above it is made heavier
TICK = 1e-3  # [s] control step: the 1 kHz of haptics; makes motion independent of the frame rate
STEP_SAFETY = 0.9  # of the stability bound: springs stiffen a little as they turn
LONGEST_STEP = 1.35  # over omega: an undamped body stiffens as it folds, and at 1.5 its energy grows
LONGEST_CONTACT = TICK / 8  # contact is resolved once a step: with longer ones a free body that is held rocks on
MAX_SUBSTEPS = 2000  # of a tick: with more, a body could not run live
ROWS = 1 << 15  # of an array at a time: what is worked out of them stays in the cache


def row_parts(count: int, wide: int = 1) -> Iterator[slice]:
    """Yield slices of `count` rows to work through one by one; a row is `wide` times as wide as usual."""
    return (slice(at, at + ROWS // wide) for at in range(0, count, ROWS // wide))


def mean_of_pairs(values: Floats, pairs: Ints) -> Floats:
    """Return the mean (m,) of the values (n,) at each pair (m, 2), in a fifth of the time of `mean(axis=1)`."""
    return (values[pairs[:, 0]] + values[pairs[:, 1]]) / 2


def sums_of_three(values: Floats) -> Floats:
    """Return the sums (t,) of three columns: `values.sum(axis=1)` in a third of the time."""
    a, b, c = values.T
    return a + b + c


def distinct(values: Ints) -> Ints:
    """Return the numbers (m,) that occur, in order: unlike `np.unique`, Python goes on meanwhile."""
    ordered = np.sort(values)
    found: Ints = ordered[np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)]]
    return found


def sums_at(index: Ints, values: Floats, n: int) -> Floats:
    """Return (n,) sums of the values (m,) that share an index (m,), always in the same order."""
    return np.bincount(index, weights=values, minlength=n).astype(np.float64, copy=False)
