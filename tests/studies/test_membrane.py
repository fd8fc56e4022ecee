"""The screened membrane in closed form: its force, its dent and its fit."""

import numpy as np
import pytest

from studies.membrane import ball_force, ball_forces, dent, fitted


@pytest.mark.parametrize("spread", [0.002, 0.010, 0.040])
@pytest.mark.parametrize("depth", [0.001, 0.020])
def test_the_bed_under_the_dent_carries_the_force(spread: float, depth: float) -> None:
    """The tension ends far away at zero, so force over kappa is the volume that the dent displaces."""
    way = np.linspace(0, 0.010 + 40 * spread, 400_001)
    displaced = 2 * np.pi * np.sum(dent(way, depth, 0.010, spread) * way) * way[1]
    assert ball_force(depth, 0.010, spread)[0] == pytest.approx(displaced, rel=1e-4)


def test_without_spread_it_is_a_bed_of_springs() -> None:
    """The force of a bed is the volume of the ball below the skin: pi x^2 (R - x / 3)."""
    depth, radius = 0.004, 0.010
    assert ball_force(depth, radius, 1e-6)[0] == pytest.approx(np.pi * depth**2 * (radius - depth / 3), rel=1e-3)


def test_a_membrane_is_found_again_from_the_force_of_one_tip() -> None:
    depths = np.linspace(0.001, 0.015, 8)
    kappa, spread = fitted([(0.010, depths, 4e5 * ball_forces(depths, 0.010, 0.013))])
    assert (kappa, spread) == pytest.approx((4e5, 0.013), rel=1e-3)
