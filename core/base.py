"""Array types, shared numbers and sums that the whole core uses.

Everything in `core` is SI: metres, kilograms, seconds, newtons, pascals.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from .errors import LARGEST as LARGEST
from .errors import DimpleError as DimpleError  # in a module of its own, because the servo process has no numpy

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Shorts = npt.NDArray[np.uint16]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

STIFFEST = 4.0  # of the median stiffness over mass: a vertex above it (of a sliver) is made heavier
TICK = 1e-3  # [s] the 1 kHz of haptics; fixed, so that the motion does not depend on the frame rate
ROWS = 1 << 15  # rows of an array that are processed together, so that intermediate results stay in the cache


def row_parts(count: int, wide: int = 1) -> Iterator[slice]:
    """Yield slices that divide `count` rows into parts of ROWS; `wide` makes the parts smaller, for wider rows."""
    return (slice(at, at + ROWS // wide) for at in range(0, count, ROWS // wide))


def mean_of_pairs(values: Floats, pairs: Ints) -> Floats:
    """Return the mean (m,) of the values (n,) at each pair (m, 2); five times faster than `mean(axis=1)`."""
    return (values[pairs[:, 0]] + values[pairs[:, 1]]) / 2


def sums_of_three(values: Floats) -> Floats:
    """Return the sums (t,) of three columns; three times faster than `values.sum(axis=1)`."""
    a, b, c = values.T
    return a + b + c


def distinct(values: Ints) -> Ints:
    """Return the distinct numbers (m,) in ascending order; unlike `np.unique` this lets other Python threads run."""
    ordered = np.sort(values)
    found: Ints = ordered[np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)]]
    return found


def sums_at(index: Ints, values: Floats, n: int) -> Floats:
    """Return the sums (n,) of the values (m,) that have the same index (m,), added in a fixed order."""
    return np.bincount(index, weights=values, minlength=n).astype(np.float64, copy=False)
