"""A round tip on a flat bed in one dimension: the closed form, and what freedom a knee wants."""

import numpy as np
import pytest

from core.body.estimate import bed_area
from core.material import FINGERTIP, PRESETS
from studies.flat_bed import least_missed, pressed

VINYL = PRESETS[1]


def test_a_bed_of_one_slope_answers_the_closed_form():
    depths, kappa, spread = np.array([0.002, 0.005, 0.010]), 4e5, 0.02
    force, _ = pressed(FINGERTIP.radius, spread, depths, kappa * spread**2, np.array([1.0]), np.array([kappa]))
    closed = [kappa * bed_area(FINGERTIP, 0.165, spread, depth)[0] * depth for depth in depths]
    assert force == pytest.approx(closed, rel=0.03)


def test_a_sharp_knee_wants_steep_slopes_and_is_met_with_them():
    free, limited = (least_missed(VINYL.material, FINGERTIP, VINYL.size, 0.022, most) for most in (1e9, 60.0))
    assert free < 0.003 < 0.01 < limited
