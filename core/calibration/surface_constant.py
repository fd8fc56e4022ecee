"""The surface's spring constant k of Eq. (4) from a press, by the balance of forces on a string.

A string of length l, pressed in its middle to a depth x by F, has two sides of length h = sqrt((l/2)^2 + x^2). So its
tension is S = F h / (2 x), and its stretch 2 h - l. The slope of S over the stretch is k.
(Eqs. (9) and (10) of the paper give k = 2 A E / l, regardless of the measurement.)
"""

from __future__ import annotations

import math

import numpy as np

from ..base import DimpleError, Floats
from .fit import slope_of

_CLEAR = 0.05  # share of the largest depth: closer to the touch the tension is 0/0, pure noise
ASSUMES = (
    "k is the slope of tension over stretch of a string of length l that is pressed in its middle. The surface is "
    "assumed to carry all of the force and the inside none."
)


def surface_constant(depth: Floats, force: Floats, length: float) -> float | None:
    """Return k [N/m], None if the press does not determine a positive one.

    Args:
        depth, force: (n,) rows of the loading, from the touch [m], [N].
        length: l, the edge of the object [m].

    Raises:
        DimpleError: the length is not greater than 0.
    """
    if not 0 < length < math.inf:
        raise DimpleError("The length of the object must be greater than 0 mm (it is {length:g}).", length=1e3 * length)
    stretch, tension = string_balance(depth, force, length)
    clear = depth > _CLEAR * depth.max()
    x, y = stretch[clear], tension[clear]
    if len(x) < 8 or np.ptp(x) == 0:
        return None
    slope, _ = slope_of(x, y)
    return slope if slope > 0 else None


def string_balance(depth: Floats, force: Floats, length: float) -> tuple[Floats, Floats]:
    """Return the stretch (n,) [m] and tension (n,) [N] of a string pressed in its middle."""
    h = np.hypot(length / 2, depth)
    return 2 * h - length, force * h / (2 * np.where(depth > 0, depth, np.inf))
