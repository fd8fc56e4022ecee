"""How large the errors of a proxy are, by its spacing: a fit, so that a plan needs no press."""

from __future__ import annotations

import math

from ..body.model import Model
from .proxy import SMALLEST, mean_spacing

# error over fingertip radius that 49 of 50 presses stay below where spacing and the spread of a dent equal this radius,
# with the powers of spacing over radius and spread over radius; and the same of the force, with the power of spacing
# over radius up to COARSE and beyond. Fitted to the proxies of the 30 bodies in studies.bodies.FITTED, pressed by half
# a radius: size, pins, fill and the knee add nothing, and to the error of the force the spread adds nothing
ERROR = 0.072, 1.72, -0.43
FORCE_ERROR = 0.36, 1.76, 3.6
COARSE = 0.8
NARROWEST = 0.5  # spread over radius: narrower dents have not been fitted


def vertices_for(
    model: Model, tolerance: float, force_tolerance: float, radius: float, share: float = 1.0
) -> int:
    """Return how many vertices a proxy needs, by the fit, to meet tolerances under a fingertip of a radius [m].

    Args:
        share: of the vertices of one that is everywhere as fine.
    """
    (factor, power, _), (force_factor, force_power, coarse_power) = ERROR, FORCE_ERROR
    by_skin = (tolerance / (radius * factor * _smoother(model, radius))) ** (1 / power)
    by_force = (force_tolerance / force_factor) ** (1 / force_power)
    if by_force > COARSE:
        by_force = COARSE * (by_force / COARSE) ** (force_power / coarse_power)
    spacing = radius * max(min(by_skin, by_force), 1e-6)
    return max(math.ceil(share * (mean_spacing(model.mesh, 1) / spacing) ** 2), SMALLEST)


def expected(model: Model, vertices: int, radius: float, share: float = 1.0) -> tuple[float, float]:
    """Return the errors of the surface [m] and of the force (a share) that a proxy should keep, by the fit.

    Args:
        share: as for `vertices_for`.
    """
    (factor, power, _), (force_factor, force_power, coarse_power) = ERROR, FORCE_ERROR
    spacing = mean_spacing(model.mesh, vertices / share) / radius
    force_error = force_factor * spacing**force_power * max(spacing / COARSE, 1.0) ** (coarse_power - force_power)
    return radius * factor * spacing**power * _smoother(model, radius), min(force_error, 1.0)


def _smoother(model: Model, radius: float) -> float:
    """Return by what the error of the surface is less where a dent is wide: the surface is smoother there."""
    return float(max(spread_of(model) / radius, NARROWEST) ** ERROR[2])


def spread_of(model: Model) -> float:
    """Return how far a dent reaches beyond a fingertip [m]: the root of tension over stiffness, in the mean."""
    # the sum of w l^2 over edges is twice the area, as the surface's own coordinates have the gradient 1
    tension = float((model.matching.tension * model.mesh.rest_lengths**2).sum()) / 2
    return math.sqrt(max(tension, 0.0) / max(float(model.matching.k1.sum()), 1e-30))
