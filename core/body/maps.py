"""Maps: what is painted on a body, vertex by vertex, and multiplies the constants of its materials."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base import Floats

LEAST = 0.05  # of the constant: a place that is painted 0 is not without it, for there is no law without a knee


class Maps(NamedTuple):
    """What the constants are multiplied by at each vertex (n,).

    stiffer: K1, K2 and the tension.
    deeper: x0.
    wider: the spread.
    thicker: the mass.
    """

    stiffer: Floats
    deeper: Floats
    wider: Floats
    thicker: Floats


def stiffness_of(softness: float | Floats) -> Any:
    """Return how many times as stiff as measured a place of this softness is: from 4 at 0 to a quarter at 1."""
    return 4.0 ** (1 - 2 * softness)


def painted(softness: Floats, knee: Floats, spread: Floats, thickness: Floats) -> Maps:
    """Return the factors (n,) of what is painted (n,), from 0 to 1 and 0.5 as measured.

    Softness 1 is four times softer, 0 four times stiffer; of the others 1 is twice the constant and 0.25 half of it.
    """
    stiffer = stiffness_of(np.clip(softness, 0, 1))
    return Maps(stiffer, *(np.clip(2 * values, LEAST, 2) for values in (knee, spread, thickness)))
