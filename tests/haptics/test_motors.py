"""The heat of the motors, over any ten seconds."""

from __future__ import annotations

import math

import pytest

from core.vectors import ZERO, Vector, dot, scaled
from studies.bench.motors import Motors
from tests.haptics.host import SPEC


def hottest(forces: list[Vector], window: float) -> float:
    """Return the largest root mean square [N] over any window [s]."""
    total, sums = 0.0, [0.0]
    for force in forces:
        total += math.hypot(*force) ** 2
        sums.append(total)
    n = round(window / SPEC.tick)
    return math.sqrt(max(b - a for a, b in zip(sums, sums[n:], strict=False)) / n) if len(sums) > n else 0.0


def rise(before: Vector, after: Vector) -> float:
    """Return how far a force is from every smaller one in the direction of that before it [N]: it may fall at once."""
    square = dot(before, before)
    return math.dist(scaled(before, min(max(dot(before, after) / square, 0.0), 1.0) if square else 0.0), after)


@pytest.mark.parametrize(
    "period", [0.5, pytest.param(3.0, marks=pytest.mark.slow), 7.0, pytest.param(1e9, marks=pytest.mark.slow)]
)
def test_no_rhythm_beats_the_heat_limit(period: float) -> None:
    """30 s of the limiter alone, on and off in any rhythm; it gives nearly all of what the limit allows."""
    motors, forces = Motors(SPEC), []
    for i in range(30_000):
        asked = 50.0 if (i * SPEC.tick) % period < period / 2 else 0.0
        forces.append(motors.limit((asked, 0.0, 0.0)))
    assert 0.99 * SPEC.continuous_force < hottest(forces, 10.0) <= SPEC.continuous_force


def test_the_continuous_force_never_folds_back() -> None:
    """40 s: a window is up to a bin, 1 %, longer than 10 s, so 0.5 % less than 4 N."""
    motors = Motors(SPEC)
    forces = [motors.limit((3.98, 0.0, 0.0))[0] for _ in range(40_000)]
    assert min(forces[10:]) == 3.98


def test_what_is_no_number_is_no_force() -> None:
    motors = Motors(SPEC)
    for bad in (math.nan, math.inf, -math.inf):
        assert motors.limit((bad, 0.0, 1.0)) == ZERO
