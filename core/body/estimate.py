"""From object constants to model constants, in closed form: the first guess that needs no simulated press.

Identification (core.calibration) replaces it where the material was calibrated on the mesh.
"""

from __future__ import annotations

import math

from ..material import Material, ModelConstants

FINGERTIP = 0.010  # [m] radius the guess is made for
MEMBRANE_SHARE = 0.25  # of the force at the knee: what the skin's own tension may answer


def estimate(material: Material, size: float) -> ModelConstants:
    """Return the model constants of a material on a body: those identified, else a guess.

    The skin across the face, a string of length l = size and stiffness k pressed in its middle, answers
    F = 2 k (2 h - l) x / h, h = sqrt((l/2)^2 + x^2): the force balance behind Eq. (9). k is scaled down where that
    alone takes more than its share of K1 x0. The rest is a bed of springs under the tip, K1 = kappa1 pi rho^2, widened
    by the skin: over r = (k x0^2 / (2 kappa1))^(1/4), where its pull balances the bed. rho^2 = R^2 (0.4 + 2 r / x0) is
    fitted to simulated presses of Table 2's cubes, and right within a factor of two there from half the knee to just
    short of it; below that a round tip starts softer than the point that measured (tests/physics/test_estimate.py).

    Args:
        size: longest side of the body [m].
    """
    if material.constants is not None:
        return material.constants
    knee = material.K1 * material.x0
    h = math.hypot(size / 2, material.x0)
    skin = 2 * material.k * (2 * h - size) * material.x0 / h
    scale = min(1.0, MEMBRANE_SHARE * knee / max(skin, 1e-30))
    kappa1 = material.K1 / (math.pi * FINGERTIP**2)
    for _ in range(20):  # a fixed point: the width depends on kappa1 by its fourth root
        width = (scale * material.k * material.x0**2 / (2 * kappa1)) ** 0.25
        kappa1 = material.K1 / (math.pi * FINGERTIP**2 * (0.4 + 2 * width / material.x0))
    return ModelConstants(
        kappa1=kappa1, kappa2=kappa1 * material.K2 / material.K1, d0=material.x0, membrane_scale=scale
    )
