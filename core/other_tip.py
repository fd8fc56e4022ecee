"""The force of a fingertip that is another than the tip that measured: times A(tip, x) / A(measuring tip, x).

A is what a tip presses on, the force over depth and stiffness. On a bed with tension it follows in closed form
(`estimate`); on an elastic solid a ball has 4/3 (R x)^(1/2) and a flat tip 2 a (Hertz 1882; Boussinesq 1885), and a
layer is stiffer under the wider of the two (Dimitriadis and others 2002): that is worked out where it is pressed,
with the thickness there.
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

FORCE = 5.0  # [N] at which softness is compared: a firm press with a finger
BODY = 0.1  # [m] the size of what it presses, on which only a spread that is not typed and a point depend
FARTHEST = 4.0  # radii, and times x0: the deepest of them


def factors(materials: Sequence[Material], radius: float, size: float) -> tuple[Floats, float] | None:
    """Return the factors (materials, FACTORS) on the force of a ball, at depths that grow with the square of their
    number, and the deepest [m]; None where it is the one that measured them all.

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
    """Return how deep a fingertip of 10 mm sinks into a material with 5 N [m]."""
    low, high = 0.0, material.x0
    force = _fingertip(material)
    while force(high) < FORCE:
        low, high = high, 2 * high
    while high - low > 1e-7 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if force(middle) < FORCE else (low, middle)
    return high


def as_soft(material: Material, depth: float) -> Material:
    """Return a material with K1 and K2 scaled so that a fingertip of 10 mm sinks in to a depth [m] with 5 N."""
    for _ in range(TURNS):  # a spread that is not typed moves a little with the stiffness
        scale = FORCE / _fingertip(material)(depth)
        material = replace(material, K1=scale * material.K1, K2=scale * material.K2)
    return material


def _fingertip(material: Material) -> Callable[[float], float]:
    """Return the force [N] of a fingertip of 10 mm over the depth [m]."""
    table = factors([material], FINGERTIP.radius, BODY)
    if table is None:
        return material.law
    (values,), end = table
    return lambda depth: material.law(depth) * float(
        np.interp(math.sqrt(depth / end), np.linspace(0, 1, FACTORS), values)
    )


@functools.lru_cache(maxsize=64)  # asked for with each press
def _factors(material: Material, ball: Indenter, size: float, end: float) -> Floats:
    depths = end * np.linspace(0, 1, FACTORS) ** 2
    depths[0] = depths[1] / 16
    return area(material, ball, size, depths) / area(material, material.indenter, size, depths)


def area(material: Material, tip: Indenter, size: float, depths: Floats) -> Floats:
    """Return what a tip presses on at depths (d,) [m]: on a bed [m2], on an elastic solid [m]."""
    if not FILLS[material.fill].elastic:
        spread = spread_on(material, size)
        return np.array([bed_area(tip, size, spread, depth)[0] for depth in depths.tolist()])
    if tip.shape == "sphere":
        return 4 / 3 * np.sqrt(tip.radius * depths)
    return np.full(len(depths), 2 * reach(tip, size))


def layer(material: Material, size: float) -> float:
    """Return where a solid was measured the radius of the ball, or minus that of the flat tip, that did [m], else 0."""
    if not FILLS[material.fill].elastic:
        return 0.0
    return math.copysign(reach(material.indenter, size), 1 if material.indenter.shape == "sphere" else -1)
