"""The screened membrane that a dent is modelled by, in closed form, against solids pressed by finite elements.

A bed of springs kappa [Pa/m] under a skin of tension T [N/m]: kappa u - T lap u = pressure. Its decay length is
lambda = sqrt(T / kappa). The body is flat and endless.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import k0e, k1e

from core.base import Floats

from .solid import SolidPress, inward

SHOWN = (1e-3, 5e-3, 10e-3, 20e-3)  # [m] depths whose force is compared; the dent from the second on


def ball_force(depth: float, radius: float, spread: float) -> tuple[float, float]:
    """Return force over kappa [m3] and contact radius [m] of a ball of a radius pressed to a depth [m]."""

    def out(a: float) -> float:  # the slope of the skin outside, where it leaves the ball
        return (depth - height(a, radius)) / spread * float(k1e(a / spread) / k0e(a / spread))

    widest = min(1 - 1e-12, np.sqrt(2 * depth / radius)) * radius
    a = float(brentq(lambda a: a / np.sqrt(radius**2 - a**2) - out(a), 1e-6 * widest, widest))
    under = (depth - radius) * a**2 / 2 + (radius**3 - (radius**2 - a**2) ** 1.5) / 3
    return 2 * float(np.pi * (under + spread**2 * a * out(a))), a


def height(r: Any, radius: float) -> Any:
    """Return how high a ball is above its lowest point at r [m]."""
    return radius - np.sqrt(radius**2 - r**2)


def ball_forces(depths: Floats, radius: float, spread: float) -> Floats:
    """Return forces over kappa (n,) [m3]."""
    return np.array([ball_force(float(depth), radius, spread)[0] for depth in depths])


def dent(way: Floats, depth: float, radius: float, spread: float) -> Floats:
    """Return how far the skin goes in (k,) [m] at a way from the axis [m]."""
    a = ball_force(depth, radius, spread)[1]
    out = np.maximum(way, a)
    outside = (depth - height(a, radius)) * k0e(out / spread) / k0e(a / spread) * np.exp((a - out) / spread)
    return np.where(way < a, depth - height(np.minimum(way, a), radius), outside)


def fitted(curves: Sequence[tuple[float, Floats, Floats]]) -> tuple[float, float]:
    """Return kappa [Pa/m] and spread [m] that come nearest to curves, each against its largest force.

    Args:
        curves: radius [m], depths (n,) [m], forces (n,) [N] of each tip.
    """

    def sides(spread: float) -> tuple[Floats, Floats]:
        model = [ball_forces(depths, radius, spread) / forces.max() for radius, depths, forces in curves]
        return np.concatenate(model), np.concatenate([forces / forces.max() for _, _, forces in curves])

    def left(logarithm: float) -> float:
        model, measured = sides(float(np.exp(logarithm)))
        return float(np.sum((measured - (model @ measured) / (model @ model) * model) ** 2))

    logarithms = np.log(np.geomspace(5e-4, 0.5, 40))
    at = int(np.argmin([left(logarithm) for logarithm in logarithms]))
    low, high = logarithms[max(at - 1, 0)], logarithms[min(at + 1, len(logarithms) - 1)]
    spread = float(np.exp(minimize_scalar(left, bounds=(low, high), method="bounded").x))
    model, measured = sides(spread)
    return float((model @ measured) / (model @ model)), spread


def dent_error(way: Floats, down: Floats, depth: float, radius: float, spread: float, *, within: float) -> float:
    """Return the RMS error of the dent over its depth, along the skin out to a distance [m].

    Args:
        way, down: (k,) of the solid's skin [m].
    """
    even = np.linspace(0, within, 400)
    return float(np.sqrt(np.mean((dent(even, depth, radius, spread) - np.interp(even, way, down)) ** 2)) / depth)


def compare(presses: Mapping[str, SolidPress], *, within: float) -> list[str]:
    """Return lines: the membrane by the force of one tip, of both, and by the dent, each against all that was computed.

    Args:
        presses: of one body by two balls, by name.
        within: how far along the skin a dent is compared [m].
    """
    curves = [(press.tip.radius, press.depth, press.force) for press in presses.values()]
    fits = {f"force of {name}": fitted([curve]) for name, curve in zip(presses, curves, strict=True)}
    fits["forces of both"] = fitted(curves)
    for name, press in presses.items():
        spread = dent_spread(press, 10e-3, within)
        model = ball_forces(press.depth, press.tip.radius, spread)
        fits[f"dent of {name}"] = float((model @ press.force) / (model @ model)), spread
    lines = []
    for name, (kappa, spread) in fits.items():
        parts = [f"  by {name:<18} spread {1e3 * spread:5.1f} mm"]
        for tip, press in presses.items():
            off = kappa * ball_forces(press.depth, press.tip.radius, spread) / press.force - 1
            shown = " ".join(f"{100 * float(np.interp(x, press.depth, off)):+4.0f}" for x in SHOWN)
            far = [dent_error(*inward(press, x), x, press.tip.radius, spread, within=within) for x in SHOWN[1:]]
            dents = " ".join(f"{100 * error:3.0f}" for error in far)
            parts.append(f"{tip}: force {shown} %, dent {dents} %")
        lines.append("; ".join(parts))
    return lines


def dent_spread(press: SolidPress, depth: float, within: float) -> float:
    """Return the spread [m] whose dent is nearest to a solid's at a depth [m]."""
    way, down = inward(press, depth)

    def off(logarithm: float) -> float:
        return dent_error(way, down, depth, press.tip.radius, float(np.exp(logarithm)), within=within)

    return float(np.exp(minimize_scalar(off, bounds=np.log([1e-3, 0.3]), method="bounded").x))
