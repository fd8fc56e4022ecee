"""What of the paper's equations no body is moved by: the energy behind Eq. (4), and Eqs. (9) and (10).

Those that move one are in core/body/paper.py.
"""

from __future__ import annotations

import numpy as np

from core.base import Floats
from core.body.springs import Springs


def spring_energy(law: Springs, x: Floats) -> float:
    """Return the energy [J] whose gradient Eq. (4) is: k (|l|^3 / (3 |l0|) - |l|^2 / 2 + |l0|^2 / 6)."""
    length, rest = np.linalg.norm(x[:, law.pairs[:, 1]] - x[:, law.pairs[:, 0]], axis=0), law.rest_lengths
    return float(law.stiffness @ (length**3 / (3 * rest) - length**2 / 2 + rest**2 / 6))


def surface_tension(force: float, depth: float, length: float) -> float:
    """Return S [N] of a surface of length l [m] pressed in its middle by a force [N] to a depth [m], Eq. (9)."""
    return float(force * depth / (2 * np.hypot(length / 2, depth)))


def surface_stretch(tension: float, length: float, section: float, youngs_modulus: float) -> float:
    """Return lambda [m] of a surface of length [m], section A [m2] and Young's modulus E [Pa], Eq. (10)."""
    return tension * length / (2 * section * youngs_modulus)
