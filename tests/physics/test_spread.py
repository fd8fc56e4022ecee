"""k carries a dent outwards: how far, in closed form, against a membrane that is never compressed and against springs.

Half and third: distance [mm] from the axis at which a dent of x0 has fallen to so much of its depth, on the top of the
paper's cubes. Membrane: relaxed, by finite elements. Springs: with all of k, no tension, and the stiffness of the bed
with which they answer K1 x0; nylon's, 22.5 mm deep in 50 mm, buckle and keep 5 mm of the dent: half at 19.6 mm, and of
the skin at 12.6. Steps of a light body.

                   spread   half: skin, membrane, springs   third: the same         steps: skin, springs
    vinyl, air       40.5         14.4   18.1   18.8        22.4   25.1   26.4        23     242
    vinyl, water     36.6         13.4   16.3   17.2        20.8   22.7   25.3        21     218
    on a ball of 165 mm, where springs become shorter as it is flattened
    vinyl, air       40.5         14.1   14.8   15.6        21.5   20.0   20.9        33     365
    vinyl, water     36.6         13.1   13.3   14.4        20.0   17.9   18.5        30     330
"""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, fsolve
from scipy.special import airy, k0e, k1e

from core.base import Floats
from core.body.estimate import bed_area, estimate, spread_on
from core.material import FINGERTIP, Material, Preset
from core.session import Finger, Session
from studies.body.dents import ball, light
from studies.paper_objects import PRESETS

VINYL = PRESETS[1].material
STIFFNESSES = np.geomspace(1, 1e6, 13)  # [N/m] k from 1e-3 to 1000 N/mm


@pytest.mark.parametrize("preset", PRESETS, ids=lambda p: p.name)
def test_a_stiffer_skin_carries_a_dent_farther_but_not_beyond_the_body(preset: Preset) -> None:
    spreads = [spread_on(replace(preset.material, k=k), preset.size) for k in STIFFNESSES]
    assert all(less < more for less, more in pairwise(spreads))
    assert spreads[0] < preset.material.x0 / 2 and spreads[-1] < preset.size
    widths = [width(preset.material, spread, 1 / 3) for spread in spreads]
    assert widths[-1] > 1.5 * widths[0]


def height(r: Any, radius: float) -> Any:
    """Return how high a ball is above its lowest point at r [m]."""
    return radius - np.sqrt(radius**2 - r**2)


def dent(way: Floats, depth: float, radius: float, spread: float) -> Floats:
    """Return how far the skin of an endless bed with a tension goes in under a ball (k,) [m], at a way from the axis.

    It follows the ball to where its slope is that of the skin outside, which decays as the Bessel function K0.
    """

    def steeper(a: float) -> float:
        out = (depth - height(a, radius)) / spread * float(k1e(a / spread) / k0e(a / spread))
        return float(a / np.sqrt(radius**2 - a**2)) - out

    widest = min(1 - 1e-12, np.sqrt(2 * depth / radius)) * radius
    a = float(brentq(steeper, 1e-6 * widest, widest))
    out = np.maximum(way, a)
    outside = (depth - height(a, radius)) * k0e(out / spread) / k0e(a / spread) * np.exp((a - out) / spread)
    return np.where(way < a, depth - height(np.minimum(way, a), radius), outside)


def width(material: Material, spread: float, share: float) -> float:
    """Return where the dent of a bed with a tension has fallen to a share of x0 [m]."""
    way = np.linspace(0, 0.2, 2000)
    return float(way[np.argmax(dent(way, material.x0, FINGERTIP.radius, spread) < share * material.x0)])


@pytest.mark.parametrize("x0", [0.005, 0.0163, 0.036])
@pytest.mark.parametrize("size", [0.05, 0.165, 0.4])
@pytest.mark.parametrize("k", [1.0, 9_200.0, 1e6])
def test_the_spread_is_where_springs_and_bed_are_in_balance(k: float, size: float, x0: float) -> None:
    material = replace(VINYL, k=k, x0=x0)
    kappa, spread = estimate(material, size).kappa1, spread_on(material, size)
    sheet = 1 / (3**0.5 / (2 * k) + 1 / (kappa * size**2))
    assert estimate(material, size).tension == pytest.approx(sheet * (x0 / spread) ** 2 / 2, rel=0.005)


WIDE = [(p.material, p.size, 0.03, 0.11) for p in PRESETS[1:]]  # and how near, at a third and at half of the depth
WIDE += [
    (replace(VINYL, k=k, x0=x0), size, *near)
    for k, x0, size, *near in (
        (1e3, 0.0163, 0.165, 0.1, 0.11), (1e6, 0.0163, 0.165, 0.03, 0.14), (9_200, 0.008, 0.165, 0.06, 0.1),
        (9_200, 0.0163, 0.4, 0.11, 0.25), (54_800, 0.036, 0.4, 0.2, 0.35),  # the wider, the less steep beside the tip
    )
]  # fmt: skip


@pytest.mark.parametrize("material, size, third, half", WIDE)
def test_a_dent_is_as_wide_as_a_membrane_makes_it_that_is_never_compressed(
    material: Material, size: float, third: float, half: float
) -> None:
    spread = spread_on(material, size)
    for share, near in ((1 / 3, third), (1 / 2, half)):
        assert width(material, spread, share) == pytest.approx(relaxed_width(material, size, share), rel=near)


@pytest.mark.parametrize("fill", ["air", "solid"])
def test_a_typed_spread_takes_the_place_of_k(fill: str) -> None:
    typed = replace(VINYL, spread=0.02, fill=fill)
    assert len({estimate(replace(typed, k=k), 0.165) for k in STIFFNESSES}) == 1
    assert estimate(typed, 0.165).tension == pytest.approx(estimate(typed, 0.165).kappa1 * 0.02**2)


def test_the_force_at_the_knee_is_the_measured_one_whatever_k_is() -> None:
    for k in STIFFNESSES:
        material = replace(VINYL, k=k)
        area, _ = bed_area(FINGERTIP, 0.165, spread_on(material, 0.165), material.x0)
        assert estimate(material, 0.165).kappa1 * area * material.x0 == pytest.approx(material.law(material.x0))


def test_the_skin_of_a_body_follows_k_and_nothing_stays_of_a_dent() -> None:
    """A ball of 2,562 vertices, pressed to x0 and let go: how deep the skin is 20 mm from the axis."""
    mesh, beside = ball(4), []
    rest = mesh.rest_positions
    near = (np.abs(np.hypot(rest[:, 0], rest[:, 1]) - 0.02) < 0.003) & (rest[:, 2] > 0)
    top = float(rest[:, 2].max()) + FINGERTIP.radius
    for k in (10.0, 1e3, 1e5):
        session = Session(light(mesh, replace(VINYL, k=k)))
        session.set_fingers([Finger((0.0, 0.0, top), FINGERTIP.radius)])
        session.set_fingers([Finger((0.0, 0.0, top - VINYL.x0), FINGERTIP.radius)])
        session.step(0.25)
        beside.append(1e3 * float((rest - session.skin())[near, 2].mean()))
        session.set_fingers([])
        session.step(0.4)
        assert np.abs(session.skin() - rest).max() < 1e-5
    assert beside == pytest.approx([0.5, 4.5, 5.8], abs=0.3)


def relaxed_width(material: Material, size: float, share: float) -> float:
    """Return where the dent of a relaxed membrane on its bed has fallen to a share of x0 [m].

    It pulls along radii alone (sigma r = P), so P w'' = kappa r w: w is an Airy function of r / l, l^3 = P / kappa. By
    the slope of the dent it is longer, half the integral of w'^2. That comes from its stretch (of 2 k / sqrt(3), as a
    net of springs) and from the bed, which gives way over all the body of radius b: P (ln(b / a) / Y + 2 / kappa b^2).
    Source: Pipkin, The relaxed energy density for isotropic elastic membranes, 1986.
    """
    tip, depth, b, young = FINGERTIP.radius, material.x0, size / 2, 2 * material.k / 3**0.5

    def contact(length: float) -> float:
        def off(a: float) -> float:
            value, slope = airy(a / length)[:2]
            return float((depth - height(a, tip)) * -slope / value / length - a / np.sqrt(tip**2 - a**2))

        return float(brentq(off, 1e-6 * tip, (1 - 1e-9) * tip))

    def dent_at(r: float, a: float, length: float) -> float:
        rim = depth - height(a, tip)
        return float(depth - height(r, tip) if r < a else rim * airy(r / length)[0] / airy(a / length)[0])

    def balance(logs: Floats) -> list[float]:
        length, kappa = np.exp(logs)
        a, pull = contact(length), kappa * length**3
        rim = (depth - height(a, tip)) / airy(a / length)[0] / length
        longer = quad(lambda r: (rim * airy(r / length)[1]) ** 2 / 2, a, b)[0]
        longer += quad(lambda r: (r / np.sqrt(tip**2 - r**2)) ** 2 / 2, 0, a)[0]
        gives = pull * (np.log(b / a) / young + 2 / (kappa * b**2))
        force = kappa * quad(lambda r: 2 * np.pi * r * dent_at(r, a, length), 0, b, points=[a])[0]
        return [float(np.log(longer / gives)), float(np.log(force / (material.K1 * depth)))]

    length, _ = np.exp(fsolve(balance, np.log([0.02, 3e5])))
    a = contact(length)
    return float(brentq(lambda r: dent_at(r, a, length) - share * depth, 0, 10 * b))
