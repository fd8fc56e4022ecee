"""The longest stable step of the explicit integrator, semi-implicit Euler."""

from __future__ import annotations

import math

from ..base import TICK

STABLE = 0.9  # share in use of a limit of stability
LONGEST_STEP = 1.35  # over omega: an undamped body stiffens when it folds; with 1.5 its energy grew
LONGEST_CONTACT = TICK / 8  # [s] step of a free body: with longer steps between contacts it rocks while it is held
MAX_SUBSTEPS = 2000  # in a tick: with more, no body runs live


def longest_step(omega_squared: float, decay: float, *, free: bool) -> float:
    """Return the longest step [s] for a highest squared frequency [1/s2] and damping rate [1/s].

    dt < 2 / omega (sqrt(1 + z^2) - z), z = decay / (2 omega), and at most LONGEST_STEP / omega for little damping.
    Source: semi-implicit Euler on a damped oscillator.
    """
    omega = math.sqrt(max(omega_squared, 1e-12))
    z = decay / (2 * omega)
    share = 2 * (math.sqrt(1 + z * z) - z) * STABLE
    return min(share / omega, LONGEST_STEP / omega, LONGEST_CONTACT if free else math.inf)
