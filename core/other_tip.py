"""The force of a fingertip that differs from the measuring tip: the law times A(tip, x) / A(measuring tip, x).

A is the force divided by depth and stiffness. For a bed with tension it has a closed form (`estimate`). For an elastic
solid A is 4/3 (R x)^(1/2) under a ball and 2 a under a flat tip (Hertz 1882; Boussinesq 1885). A thin layer is stiffer
under the wider tip (Dimitriadis and others 2002); that factor depends on the thickness at the place of contact, so the
C core evaluates it there.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .base import Floats
from .body.estimate import TURNS, bed_area, reach, spread_on
from .constants import FACTORS
from .fills import FILLS
from .material import FINGERTIP, Indenter, Material

FORCE = 5.0  # [N] at which objects are compared for softness: a firm press with a finger
BODY = 0.1  # [m] size of the body in this comparison; it matters only for a default spread and a point
FARTHEST = 4.0  # the table of factors ends at this many radii or knees, whichever is deeper


def factors(materials: Sequence[Material], radius: float, size: float) -> tuple[Floats, float] | None:
    """Return the factors (materials, FACTORS) on the force of a ball, and the last of their depths [m].

    The depths grow with the square of the index. None if this ball measured all materials.

    Args:
        radius: of the ball [m].
        size: longest side of the body [m].
    """
    ball = Indenter(shape="sphere", radius=radius)
    if all(material.indenter == ball for material in materials):
        return None
    end = FARTHEST * max(radius, *(material.x0 for material in materials))
    return np.stack([_factors(material, ball, size, end) for material in materials]), end


def softness(material: Material) -> float:
    """Return the depth [m] to which 5 N press a fingertip of 10 mm into a material."""
    low, high = 0.0, material.x0
    force = _fingertip(material)
    while force(high) < FORCE:
        low, high = high, 2 * high
    while high - low > 1e-7 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if force(middle) < FORCE else (low, middle)
    return high


def as_soft(material: Material, depth: float) -> Material:
    """Return a material with K1 and K2 scaled so that 5 N press a fingertip of 10 mm to a depth [m]."""
    for _ in range(TURNS):  # the default spread depends a little on the stiffness
        scale = FORCE / _fingertip(material)(depth)
        material = replace(material, K1=scale * material.K1, K2=scale * material.K2)
    return material


def _fingertip(material: Material) -> Callable[[float], float]:
    """Return the force [N] of a fingertip of 10 mm as a function of the depth [m]."""
    table = factors([material], FINGERTIP.radius, BODY)
    if table is None:
        return material.law
    (values,), end = table
    return lambda depth: material.law(depth) * float(
        np.interp(math.sqrt(depth / end), np.linspace(0, 1, FACTORS), values)
    )


@functools.lru_cache(maxsize=64)  # each press needs it
def _factors(material: Material, ball: Indenter, size: float, end: float) -> Floats:
    depths = end * np.linspace(0, 1, FACTORS) ** 2
    depths[0] = depths[1] / 16
    return area(material, ball, size, depths) / area(material, material.indenter, size, depths)


def area(material: Material, tip: Indenter, size: float, depths: Floats) -> Floats:
    """Return A of a tip at depths (d,) [m]: in [m2] on a bed, in [m] on an elastic solid."""
    if not FILLS[material.fill].elastic:
        spread = spread_on(material, size)
        return np.array([bed_area(tip, size, spread, depth)[0] for depth in depths.tolist()])
    if tip.shape == "sphere":
        return 4 / 3 * np.sqrt(tip.radius * depths)
    return np.full(len(depths), 2 * reach(tip, size))


def layer(material: Material, size: float) -> float:
    """Return for a solid the radius [m] of the measuring ball, or minus that of a flat tip; for other fills 0."""
    if not FILLS[material.fill].elastic:
        return 0.0
    return math.copysign(reach(material.indenter, size), 1 if material.indenter.shape == "sphere" else -1)
