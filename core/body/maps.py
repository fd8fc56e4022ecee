"""Maps: what is painted on a body, vertex by vertex, and multiplies the constants of its materials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints
from ..material import Material
from .estimate import estimate

LEAST = 0.05  # of the constant: a place that is painted 0 is not without it, for there is no law without a knee

# times x0: where the closed form is evaluated
KNEES = (*np.geomspace(LEAST, 1, 14).tolist(), *np.geomspace(1, 2, 5)[1:].tolist())


class Maps(NamedTuple):
    """What the constants are multiplied by at each vertex (n,).

    stiffer: K1, K2, k and the tension.
    deeper: x0.
    wider: the spread.
    thicker: k and the mass.
    """

    stiffer: Floats
    deeper: Floats
    wider: Floats
    thicker: Floats


def painted(softness: Floats, knee: Floats, spread: Floats, thickness: Floats) -> Maps:
    """Return the factors (n,) of what is painted (n,), from 0 to 1 and 0.5 as measured.

    Softness 1 is four times softer, 0 four times stiffer; of the others 1 is twice the constant and 0.25 half of it.
    """
    stiffer = 4.0 ** (1 - 2 * np.clip(softness, 0, 1))
    return Maps(stiffer, *(np.clip(2 * values, LEAST, 2) for values in (knee, spread, thickness)))


def stiffness_at_knees(
    materials: Sequence[Material], size: float, which: Ints, deeper: Floats
) -> tuple[Floats, Floats]:
    """Return by what the stiffness up to the knee, and what is added beyond it, change where x0 is painted (t,).

    A round tip touches less of the surface at a shallower knee: for the same K1 the surface there is stiffer, by the
    closed form.

    Args:
        size: of the body [m].
        which: (t,) material of each triangle.
        deeper: (t,) times x0.
    """
    first, beyond = np.ones(len(which)), np.ones(len(which))
    if (deeper == 1).all():
        return first, beyond
    for index, material in enumerate(materials):
        found = [estimate(replace(material, constants=None, x0=share * material.x0), size) for share in (1, *KNEES)]
        here = which == index
        for factor, law in ((first, [e.kappa1 for e in found]), (beyond, [e.kappa2 - e.kappa1 for e in found])):
            if law[0]:
                factor[here] = np.interp(deeper[here], KNEES, np.array(law[1:]) / law[0])
    return first, beyond
