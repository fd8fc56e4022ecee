"""The constants of the model from the constants of a material, in closed form.

Shape matching with a tension is a membrane on a bed of springs. Outside the radius a of contact a dent decays as the
modified Bessel function K0(r / lambda), where lambda is the spread. With its decay length at the edge of the contact,
s(a) = lambda K1(a / lambda) / K0(a / lambda), a bed of stiffness kappa resists a depth x with

    a flat punch of radius a   F = kappa x (pi a^2 + 2 pi a s)
    a sphere of radius R       F = kappa (integral of w over pi a^2 + 2 pi a s w(a)),  lambda^2 |w'| = s w at a

with w(r) = x - R + (R^2 - r^2)^(1/2), on a flat surface that is thicker and wider than the spread.
tests/physics/test_estimate.py states the error.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from ..base import Floats
from ..fills import FILLS
from ..material import HERTZ, Indenter, Material

POINT_SHARE = 1 / 16  # of the size: radius of the patch that replaces a point, which no mesh can resolve
TURNS = 8  # iterations of a fixed point: enough for an error below 0.1 %
SPRINGS = 1 / 4  # of the tension: a face under a dragged tip keeps 0.34 of its area (0.07 without springs)
BEYOND = 0.6  # of the rim's length: the dent widens while the depth goes beyond the knee
SOLID_SKIN = 80.0  # stiffness of a solid's skin over that of its bed; gives its dents the shape of finite elements


class ModelConstants(NamedTuple):
    """Constants with which the model resists the measuring tip as the material does.

    kappa1, kappa2: stiffness of shape matching per area up to the knee and beyond it [N/m3].
    d0: displacement at the knee [m].
    tension: between the displacements of neighbours [N/m].
    """

    kappa1: float
    kappa2: float
    d0: float
    tension: float


def reach(indenter: Indenter, size: float) -> float:
    """Return the radius [m] of the tip; a point becomes a patch that a mesh can resolve."""
    return max(indenter.radius, POINT_SHARE * size) if indenter.shape == "point" else indenter.radius


@functools.lru_cache(maxsize=64)  # takes milliseconds, and each change of constants needs it several times
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
    """Return the area A [m2] in F = kappa A depth of a solid, whose skin is `skin` times as stiff as its bed.

    It approximates skin and bed in series by combining their forces at the same depth: 13 % too large at a depth of a
    tenth of the radius, 1 to 6 % from half a radius on.
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
    """Return log z and log K1(z) / K0(z), from the integral representations of both, to 1e-5."""
    z = np.geomspace(1e-7, 1e3, 1000)
    most = np.arccosh(1 + 40 / z)  # the integrand vanishes beyond; the trapezoidal rule is exact to 1e-9
    t = np.linspace(0, 1, 400)[:, None] * most
    weight = np.exp(-z * (np.cosh(t) - 1))
    weight[0] /= 2
    return np.log(z), np.log((weight * np.cosh(t)).sum(axis=0) / weight.sum(axis=0))


@functools.lru_cache(maxsize=64)
def spread_on(material: Material, size: float) -> float:
    """Return the spread of a dent [m]: as typed, or the distance to which springs of constant k spread it.

    A net of springs is a sheet of stiffness Y = 2 k / 3^(1/2). A dent of depth x0 and width lambda strains it by
    (x0 / lambda)^2 / 2, which gives a tension T = Y' (x0 / lambda)^2 / 2. A stiff sheet pulls in skin from the whole
    body, against the bed: 1 / Y' = 1 / Y + 1 / (kappa size^2). With T = kappa lambda^2 it follows that
    lambda^4 = x0^2 / 2 / (kappa / Y + 1 / size^2), where kappa depends slightly on lambda.
    tests/physics/test_spread.py compares this with dents of the springs themselves.

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

    kappa1 reproduces the law of the measuring tip at the knee. Beyond the knee only the skin under the tip and a rim of
    width sqrt(T / kappa2) is displaced far enough to be stiffer. With kappa = kappa2 - kappa1 that is
    K2 - K1 = kappa pi a^2 + BEYOND 2 pi a sqrt(kappa T).

    Args:
        size: longest side of the body [m].
    """
    spread = spread_on(material, size)
    kappa1, radius = _bed(material, size, spread)
    tension = kappa1 * spread**2
    # a quadratic equation in sqrt(kappa)
    bed, rim = math.pi * radius**2, BEYOND * math.pi * radius * math.sqrt(tension)
    more = max(material.K2 - material.K1, 0.0)
    root = (math.sqrt(rim**2 + bed * more) - rim) / bed
    kappa2 = max(kappa1 + root**2, kappa1 * min(material.K2 / material.K1, 1.0))
    return ModelConstants(kappa1=kappa1, kappa2=kappa2, d0=material.x0, tension=tension)


def _bed(material: Material, size: float, spread: float) -> tuple[float, float]:
    """Return the stiffness of the bed up to the knee [N/m3] and the radius of contact at the knee [m]."""
    area, radius = bed_area(material.indenter, size, spread, material.x0)
    if FILLS[material.fill].elastic:
        area = solid_area(material.indenter, size, spread, material.x0, _solid_skin(material))
    return material.law(material.x0) / material.x0 / area, radius


def skin_compliance(material: Material, constants: ModelConstants) -> float:
    """Return the compliance of the skin under the pressure of a fingertip [m/Pa]; 0 unless the body is a solid.

    The dent of a solid is steeper beside the fingertip than that of a bed with tension, and reaches farther. A skin in
    series that is SOLID_SKIN times as stiff as the bed gives both. A material that hardens more than an elastic solid
    gets a harder skin, since otherwise the skin would take all the depth beyond the knee.
    Source: Kerr, On the formal development of elastic foundation models, 1984.
    """
    if not FILLS[material.fill].elastic:
        return 0.0
    return 1 / (_solid_skin(material) * constants.kappa1)


def _solid_skin(material: Material) -> float:
    """Return the stiffness of a solid's skin over that of its bed."""
    elastic = HERTZ**2 if material.indenter.shape == "sphere" else 1.0  # a flat tip measures one slope
    return SOLID_SKIN * max(material.K2 / (elastic * material.K1), 1.0) ** 2
