"""From object constants to model constants, in closed form: where identification starts, and what holds until then.

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
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..material import HERTZ, Indenter, Material, ModelConstants

POINT_SHARE = 1 / 16  # of the size: the patch that stands for a point
MEMBRANE_SHARE = 0.05  # of the force at the knee: what the surface's own springs may answer
LEAST_TENSION = 0.5  # of it, k may be: stiffer springs would buckle where they are compressed, and keep the dent
BEYOND = 0.6  # of the rim's length: beyond the knee the dent widens meanwhile
AT_KNEE = 0.9  # of x0: where a knee is painted, pieces of the bed's law that begin deeper belong to K2
JUMP = 0.6  # of x0: so they do where constants are rescaled, for a round tip's bed jumps early
SOLID_SKIN = 80.0  # times as stiff as its bed the skin of a solid is
# times: how far K1 and K2, and x0 and the spread, may change before the closed form is as good as what was identified
NEAR, NEAR_LENGTH = 8.0, 2.0


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
        if spread**2 * a > falloff(a, spread) * rise * (depth - radius + rise):
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
    """Return s = lambda K1(a / lambda) / K0(a / lambda) [m], from the integrals of exp(-z cosh t) and its moment."""
    z = radius / max(spread, 1e-3 * radius)
    t = np.linspace(0, math.acosh(1 + 40 / z), 400)  # beyond it nothing is left; the trapezoids are exact to 1e-9
    weight = np.exp(-z * (np.cosh(t) - 1))
    weight[0] /= 2
    return spread * float(weight @ np.cosh(t)) / float(weight.sum())


def estimate(material: Material, size: float) -> ModelConstants:
    """Return the model constants of a material on a body: those identified, else those of the closed form.

    kappa1 is that with which the measuring tip answers the law at the knee. Beyond it only what lies under the tip and
    a rim of width sqrt(T / kappa2) is displaced far enough to be stiffer: (K2 - K1) = kappa pi a^2 + BEYOND 2 pi a
    sqrt(kappa T), kappa = kappa2 - kappa1. Springs stretched over a dent of width lambda answer about pi/2 k x^3 /
    lambda^2; k is scaled down where that would be more than their share, or where they could buckle.

    Args:
        size: longest side of the body [m].
    """
    if material.constants is not None:
        return material.constants
    spread, knee = material.spread, material.x0
    area, radius = bed_area(material.indenter, size, spread, knee)
    if material.fill == "solid":
        area = solid_area(material.indenter, size, spread, knee, _solid_skin(material))
    kappa1 = material.law(knee) / knee / area
    tension = kappa1 * spread**2
    # a quadratic in the root of kappa
    bed, rim = math.pi * radius**2, BEYOND * math.pi * radius * math.sqrt(tension)
    more = max(material.K2 - material.K1, 0.0)
    root = (math.sqrt(rim**2 + bed * more) - rim) / bed
    width = max(spread, radius)
    skin = math.pi / 2 * material.k * knee**3 / width**2
    scale = min(MEMBRANE_SHARE * material.K1 * knee / skin, LEAST_TENSION * (tension + kappa1 * radius**2) / material.k)
    return ModelConstants(
        kappa1=kappa1, kappa2=max(kappa1 + root**2, kappa1 * min(material.K2 / material.K1, 1.0)), d0=knee,
        membrane_scale=min(scale, 1.0),
    )  # fmt: skip


def skin_compliance(material: Material, constants: ModelConstants) -> float:
    """Return how far the skin gives way under the pressure of a fingertip [m/Pa]: that of a solid does, others not.

    A solid's dent is steeper beside a fingertip than that of a bed under a tension, and reaches farther. So is it with
    a skin in series that is SOLID_SKIN times as stiff as the bed, and forces go with the tip's radius as a solid's do.
    What hardens more than an elastic solid has a harder skin, or the skin would give all the depth beyond the knee.
    Source: Kerr, On the formal development of elastic foundation models, 1984.
    """
    if material.fill != "solid":
        return 0.0
    # the tension tells it as it was scaled, whatever law in pieces the bed has been given since
    bed = constants.tension / material.spread**2 if constants.tension and material.spread else constants.kappa1
    return 1 / (_solid_skin(material) * bed)


def _solid_skin(material: Material) -> float:
    """Return how many times as stiff as its bed the skin of a solid is."""
    elastic = HERTZ**2 if material.indenter.shape == "sphere" else 1.0  # a flat tip measures one slope
    return SOLID_SKIN * max(material.K2 / (elastic * material.K1), 1.0) ** 2


def rescaled(constants: ModelConstants, identified: Material, material: Material, size: float) -> ModelConstants | None:
    """Return constants that were identified for one material, changed as the closed form changes for another.

    What lies before the knee goes with K1, displacements with x0. What is added beyond it does not depend on x0 itself:
    how much of a tip is deeper than the knee is a matter of the depth beyond it. At the knee it goes as the closed form
    says, in which a tension that stays gives the dent a narrower rim; in a deep dent, where little is left to widen, as
    K2 - K1: between the two it is their geometric mean. So where all of them change alike, all forces do, exactly.

    Args:
        identified: what they were identified for.
        material: with other K1, K2, x0, k or spread.
        size: longest side of the body [m].

    Returns:
        None where the two are too different for that.
    """
    if not _are_near(identified, material):
        return None
    old, new, same_knee = (
        estimate(replace(each, constants=None), size)
        for each in (identified, material, replace(material, x0=identified.x0))
    )
    first, more = new.kappa1 / old.kappa1, old.kappa2 - old.kappa1
    beyond = first
    if more > 0:
        straight = max(material.K2 - material.K1, 0.0) / (identified.K2 - identified.K1)
        beyond = math.sqrt(straight * (same_knee.kappa2 - same_knee.kappa1) / more)
    deeper, wider = material.x0 / identified.x0, material.spread / identified.spread if identified.spread else 1.0
    kappa1, skin = constants.kappa1, constants.membrane_scale * new.membrane_scale / old.membrane_scale
    tension = kappa1 * identified.spread**2 if constants.tension is None else constants.tension
    return replace(
        constants, kappa1=first * kappa1, kappa2=first * kappa1 + beyond * (constants.kappa2 - kappa1),
        d0=deeper * constants.d0, membrane_scale=min(skin, 1.0), tension=first * wider**2 * tension,
        pieces=tuple(
            (deeper * knee, (first if knee < JUMP * identified.x0 else beyond) * slope)
            for knee, slope in constants.pieces
        ),
    )  # fmt: skip


def between(identified: Sequence[Material], material: Material, size: float) -> ModelConstants | None:
    """Return constants that were identified for one material or two, rescaled for another, by how near it is to each.

    Args:
        identified: with their constants.
        material, size: as for `rescaled`.

    Returns:
        None where it is far from all of them.
    """
    near = [
        (_apart(each, material), found) for each in identified
        if each.constants and (found := rescaled(each.constants, each, material, size))
    ]  # fmt: skip
    if len(near) < 2 or near[0][0] == 0:
        return near[0][1] if near else None
    (one, first), (other, second) = near
    return _mixed(first, second, one / (one + other), material.spread)


def _mixed(one: ModelConstants, other: ModelConstants, share: float, spread: float) -> ModelConstants:
    """Return constants with a share of others: at the same displacements the force is in between, for it is linear."""
    weighed = (1 - share, one), (share, other)
    more: dict[float, float] = {}
    for weight, each in weighed:
        for knee, stiffness in each.pieces:
            knee = round(knee, 9)  # [m]: those of both that are rescaled from one depth
            more[knee] = more.get(knee, 0.0) + weight * stiffness

    def mean(of: Callable[[ModelConstants], float]) -> float:
        return sum(weight * of(each) for weight, each in weighed)

    return ModelConstants(
        kappa1=mean(lambda c: c.kappa1), kappa2=mean(lambda c: c.kappa2), d0=mean(lambda c: c.d0),
        membrane_scale=mean(lambda c: c.membrane_scale), pieces=tuple(sorted(more.items())),
        tension=mean(lambda c: c.kappa1 * spread**2 if c.tension is None else c.tension),
    )  # fmt: skip


def _apart(one: Material, other: Material) -> float:
    """Return by how much what was measured differs: the sum of the logarithms of how many times."""
    lengths = (1 + abs(one.spread - other.spread) / one.x0,)
    times = (one.K1 / other.K1, one.K2 / other.K2, one.x0 / other.x0, one.k / other.k, *lengths)
    return sum(abs(math.log(each)) for each in times)


def _are_near(one: Material, other: Material) -> bool:
    """Tell whether two materials, measured with the same tip, differ by a few times at most in what was measured."""
    lengths = ((one.x0, other.x0), (one.spread, other.spread))
    before, after = one.K2 - one.K1, other.K2 - other.K1
    return (
        (one.indenter, one.fill) == (other.indenter, other.fill)
        and one.K1 <= NEAR * other.K1 <= NEAR**2 * one.K1
        and all(a <= NEAR_LENGTH * b and b <= NEAR_LENGTH * a for a, b in lengths)
        and after <= max(NEAR * before, 0.0)
    )
