"""The vocabulary of the core: units, named tolerances, and the one error an artist sees.

Everything in `core` is SI: metres, kilograms, seconds, newtons, pascals.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .errors import DimpleError as DimpleError  # it lives apart so that the servo process has it without numpy

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

STANDARD_GRAVITY = 9.81  # [m/s2]
AIR_PRESSURE = 101_325.0  # [Pa] outside every body
AIR_EXPONENT = 1.4  # a press is quick beside the warming of the air: adiabatic
# [Pa] a thousandth of real water: a fingertip's few kPa change the volume by well under 0.5 %, and the
# pressure wave does not ask for smaller steps than the skin does (tests/physics/test_volume.py)
LIQUID_BULK_MODULUS = 2e6

FARTHEST = 1e9  # [m] a vertex farther away than the moon is a mistake
WELD_SHARE = 1e-6  # of the bounding box: nearer vertices are one vertex
CLOSED_BULK = 1e-6  # of size x area: a closed body with less volume has no inside
OPEN_BULK = 1e-2  # the same of an open one: a crumpled or curved sheet is no body (a hemisphere has 0.17)
MASS_FLOOR = 1e-2  # of the mean: no vertex is lighter
STIFFEST = 4.0  # of the median stiffness over mass: a sliver's vertex is made heavier rather than set the time step
TICK = 1e-3  # [s] control step: haptics' 1 kHz, and what makes motion independent of the frame rate
STEP_SAFETY = 0.9  # of the stability bound; springs stiffen a little when they turn
MAX_SUBSTEPS = 2000  # a tick finer than this would never be live
SKIN_TRAVEL = 0.5  # of a fingertip's radius: what the skin may move in one substep without passing the fingertip
LARGEST_GROWTH = 100.0  # times its size at rest: a body as large has blown up
FINGER_TRAVEL = 0.25  # of its radius: what a fingertip may move in one tick without skipping over a skin


def sums_at(index: Ints, values: Floats, n: int) -> Floats:
    """Return (n,) sums of the values (m,) that share an index (m,), always in the same order."""
    return np.bincount(index, weights=values, minlength=n).astype(np.float64, copy=False)
