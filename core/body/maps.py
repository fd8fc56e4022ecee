"""Painted maps: factors on the constants of the materials, vertex by vertex."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base import Floats
from ..constants import ROUNDING


class Maps(NamedTuple):
    """Factors at each vertex (n,).

    stiffer: on K1, K2 and the tension.
    deeper: on x0.
    wider: on the spread.
    """

    stiffer: Floats
    deeper: Floats
    wider: Floats


def stiffness_of(softness: float | Floats) -> Any:
    """Return the factor on the stiffness for a painted softness: 4 at 0, 1 at 0.5, a quarter at 1."""
    return 4.0 ** (1 - 2 * softness)


def painted(softness: Floats, knee: Floats, spread: Floats) -> Maps:
    """Return the factors (n,) for painted values (n,) from 0 to 1, where 0.5 means as measured.

    A softness of 1 is four times softer, 0 four times stiffer. The other maps multiply by twice the painted value, and
    by almost 0 where that is 0: a law needs a knee.
    """
    stiffer = stiffness_of(np.clip(softness, 0, 1))
    return Maps(stiffer, *(np.clip(2 * values, ROUNDING, 2) for values in (knee, spread)))
