"""From object constants to model constants, in closed form.

Shape matching with a tension is a membrane on a bed of springs. Pressed by x, its dent falls off as the modified Bessel
function K0(r / lambda) beyond the radius a of contact, lambda being the spread. With s(a) = lambda K1(a / lambda) /
K0(a / lambda), the length in which it falls off there, a bed of stiffness kappa answers

    a flat punch of radius a   F = kappa x (pi a^2 + 2 pi a s)
    a sphere of radius R       F = kappa (integral of w over pi a^2 + 2 pi a s w(a)),  lambda^2 |w'| = s w at a

with w(r) = x - R + (R^2 - r^2)^(1/2), on a flat surface that is thick and wide beside the spread.
tests/physics/test_estimate.py says how far it is off.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from ..base import Floats
from ..fills import FILLS
from ..material import HERTZ, Indenter, Material

POINT_SHARE = 1 / 16  # of the size: the patch that stands for a point
TURNS = 8  # iterations of the fixed point: enough for an error below 0.1 %
SPRINGS = 1 / 4  # of the tension: a face under a dragged tip keeps 0.34 of its area (0.07 without); more cost steps
BEYOND = 0.6  # of the rim's length: beyond the knee the dent widens meanwhile
SOLID_SKIN = 80.0  # times as stiff as its bed the skin of a solid is


class ModelConstants(NamedTuple):
    """Constants of the model with which it answers the measuring tip as the material does.

    kappa1, kappa2: stiffness of shape matching per area, up to the knee and beyond it [N/m3].
    d0: displacement at the knee [m].
    tension: between the displacements of neighbours [N/m].
    """

    kappa1: float
    kappa2: float
    d0: float
    tension: float


def reach(indenter: Indenter, size: float) -> float:
    """Return the radius [m] of what presses: a point is a patch that the mesh can show."""
    return max(indenter.radius, POINT_SHARE * size) if indenter.shape == "point" else indenter.radius


@functools.lru_cache(maxsize=64)  # some milliseconds, and asked for several times with each change of constants
def bed_area(indenter: Indenter, size: float, spread: float, depth: float) -> tuple[float, float]:
    """Return the area A [m2] in F = kappa A depth, and the radius of contact [m], of an indenter on a flat surface."""
    radius = reach(indenter, size)
    if indenter.shape != "sphere":
        return math.pi * radius**2 + 2 * math.pi * radius * falloff(radius, spread), radius
    low, high = 0.0, radius * (1 - 1e-9)
    for _ in range(60):
        a = (low + high) / 2
        rise = math.sqrt(radius**2 - a**2)
        if depth < radius - rise or spread**2 * a > falloff(a, spread) * rise * (depth - radius + rise):
            high = a
        else:
            low = a
    bed = math.pi * a**2 * (depth - radius) + 2 * math.pi / 3 * (radius**3 - rise**3)
    return (bed + 2 * math.pi * a * falloff(a, spread) * (depth - radius + rise)) / depth, a


def solid_area(indenter: Indenter, size: float, spread: float, depth: float, skin: float) -> float:
    """Return the area A [m2] in F = kappa A depth of a solid, whose skin is some times as stiff as its bed.

    It is that of the bed and that of the skin alone, at the same depth, in series: 1 to 6 % too much from half a radius
    of depth on, 13 % at a tenth.
    """
    radius = reach(indenter, size)
    volume = math.pi * radius**2 * depth
    if indenter.shape == "sphere":
        volume -= math.pi * radius**3 / 3
        if depth < radius:
            volume = math.pi * depth**2 * (radius - depth / 3)
    return 1 / (1 / bed_area(indenter, size, spread, depth)[0] + depth / (skin * volume))


def falloff(radius: float, spread: float) -> float:
    """Return s = lambda K1(a / lambda) / K0(a / lambda) [m]."""
    z = math.log(radius / max(spread, 1e-3 * radius))
    return spread * math.exp(float(np.interp(z, *_falloffs())))


@functools.cache
def _falloffs() -> tuple[Floats, Floats]:
    """Return log z, and log K1(z) / K0(z) from the integrals of exp(-z cosh t) and its moment; right to 1e-5."""
    z = np.geomspace(1e-7, 1e3, 1000)
    most = np.arccosh(1 + 40 / z)  # beyond it nothing is left; the trapezoids are exact to 1e-9
    t = np.linspace(0, 1, 400)[:, None] * most
    weight = np.exp(-z * (np.cosh(t) - 1))
    weight[0] /= 2
    return np.log(z), np.log((weight * np.cosh(t)).sum(axis=0) / weight.sum(axis=0))


@functools.lru_cache(maxsize=64)
def spread_on(material: Material, size: float) -> float:
    """Return how far a dent reaches beyond the fingertip [m]: as typed, or as far as springs of constant k carry it.

    A net of springs is a sheet of stiffness Y = 2 k / 3^(1/2). Over a dent of depth x0 and width lambda it is longer by
    (x0 / lambda)^2 / 2, and pulls with T = Y' (x0 / lambda)^2 / 2. A stiff one pulls the skin along, from all over the
    body, against the bed that holds it in its place: 1 / Y' = 1 / Y + 1 / (kappa size^2). With T = kappa lambda^2 that
    is lambda^4 = x0^2 / 2 / (kappa / Y + 1 / size^2), where kappa depends on lambda a little.
    tests/physics/test_spread.py says how wide the springs themselves make a dent.

    Args:
        size: longest side of the body [m].
    """
    if material.spread is not None:
        return material.spread
    sheet, spread = 2 * material.k / math.sqrt(3), math.sqrt(material.x0 * size)
    for _ in range(TURNS):
        gives = _bed(material, size, spread)[0] / sheet + size**-2
        spread = math.sqrt(material.x0 / math.sqrt(2 * gives))
    return spread


def estimate(material: Material, size: float) -> ModelConstants:
    """Return the model constants of a material on a body, in closed form.

    kappa1 is that with which the measuring tip answers the law at the knee. Beyond it only what lies under the tip and
    a rim of width sqrt(T / kappa2) is displaced far enough to be stiffer: (K2 - K1) = kappa pi a^2 + BEYOND 2 pi a
    sqrt(kappa T), kappa = kappa2 - kappa1.

    Args:
        size: longest side of the body [m].
    """
    spread = spread_on(material, size)
    kappa1, radius = _bed(material, size, spread)
    tension = kappa1 * spread**2
    # a quadratic in the root of kappa
    bed, rim = math.pi * radius**2, BEYOND * math.pi * radius * math.sqrt(tension)
    more = max(material.K2 - material.K1, 0.0)
    root = (math.sqrt(rim**2 + bed * more) - rim) / bed
    kappa2 = max(kappa1 + root**2, kappa1 * min(material.K2 / material.K1, 1.0))
    return ModelConstants(kappa1=kappa1, kappa2=kappa2, d0=material.x0, tension=tension)


def _bed(material: Material, size: float, spread: float) -> tuple[float, float]:
    """Return the stiffness of the bed up to the knee [N/m3] and the radius of contact there [m]."""
    area, radius = bed_area(material.indenter, size, spread, material.x0)
    if FILLS[material.fill].elastic:
        area = solid_area(material.indenter, size, spread, material.x0, _solid_skin(material))
    return material.law(material.x0) / material.x0 / area, radius


def skin_compliance(material: Material, constants: ModelConstants) -> float:
    """Return how far the skin gives way under the pressure of a fingertip [m/Pa]: that of a solid does, others not.

    A solid's dent is steeper beside a fingertip than that of a bed under a tension, and reaches farther. So is it with
    a skin in series that is SOLID_SKIN times as stiff as the bed, and forces go with the tip's radius as a solid's do.
    What hardens more than an elastic solid has a harder skin, or the skin would give all the depth beyond the knee.
    Source: Kerr, On the formal development of elastic foundation models, 1984.
    """
    if not FILLS[material.fill].elastic:
        return 0.0
    return 1 / (_solid_skin(material) * constants.kappa1)


def _solid_skin(material: Material) -> float:
    """Return how many times as stiff as its bed the skin of a solid is."""
    elastic = HERTZ**2 if material.indenter.shape == "sphere" else 1.0  # a flat tip measures one slope
    return SOLID_SKIN * max(material.K2 / (elastic * material.K1), 1.0) ** 2
