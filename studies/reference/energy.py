"""The energies of the laws of a body [J], of which the forces in `core.body` are the negative gradients."""

from __future__ import annotations

import numpy as np

from core.base import Floats
from core.body.model import Model
from core.body.pressure import Pressure, volume_and_gradient
from core.body.shape_matching import Pose, ShapeMatching, displacements
from core.body.springs import Springs
from core.constants import AIR_EXPONENT, AIR_PRESSURE, LIQUID_BULK_MODULUS
from core.fills import PressureLaw

from .laws import pose_of


def of_springs(law: Springs, x: Floats) -> float:
    """Return the energy at positions (3, n) [m]."""
    stretch = np.linalg.norm(x[:, law.pairs[:, 1]] - x[:, law.pairs[:, 0]], axis=0) - law.rest_lengths
    return float(law.stiffness @ stretch**2) / 2


def of_fill(law: Pressure, x: Floats) -> float:
    """Return the energy at positions (3, n) [m]; 0 at the volume at rest."""
    now, _ = volume_and_gradient(law, x)
    if law.kind is PressureLaw.GAS:
        g, v0 = AIR_EXPONENT, law.rest_volume
        squeezed = v0 * ((v0 / now) ** (g - 1) - 1) / (g - 1)
        return AIR_PRESSURE * (squeezed - (v0 - now)) + law.rest_pressure * squeezed
    if law.kind is PressureLaw.BULK:
        less = law.rest_volume - now
        return (LIQUID_BULK_MODULUS * less / (2 * law.rest_volume) + law.rest_pressure) * less
    return 0.0


def of_matching(law: ShapeMatching, x: Floats, pose: Pose | None = None) -> float:
    """Return the energy at positions (3, n) [m]; pose: of the shape at rest if pins hold it, None for a free body."""
    u = displacements(law, x, pose_of(law, x, pose))
    d, (i, j) = np.linalg.norm(u, axis=0), law.pairs.T
    bed = float((law.k1 * d**2 + (law.k2 - law.k1) * np.maximum(d - law.d0, 0) ** 2).sum())
    return (bed + float(law.tension @ ((u[:, i] - u[:, j]) ** 2).sum(axis=0))) / 2


def stored(model: Model, x: Floats, pose: Pose | None = None) -> float:
    """Return the energy of all laws of a model at positions (3, n) [m]; pose: see `of_matching`."""
    return of_springs(model.springs, x) + of_fill(model.pressure, x) + of_matching(model.matching, x, pose)
