"""Where methods diverge is where theory says, and what energy they keep is what theory says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from core.body.time_step import LONGEST_CONTACT
from studies.charts.stability import bound, cell, diverges, linearised, measured_boundary, shaken, small_body
from studies.methods.energy import artificial_damping, backward_euler_damping, energy_trace
from studies.methods.motion import move
from studies.methods.registry import METHODS

EXPLICIT = [name for name, method in METHODS.items() if method.kind == "explicit"]
UNBOUNDED = [name for name, method in METHODS.items() if method.kind != "explicit"]


@pytest.mark.parametrize("k", [6.0, pytest.param(60_000.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("method", EXPLICIT)
def test_an_explicit_method_diverges_within_a_tenth_of_its_bound(method: str, k: float) -> None:
    model = small_body(k)
    theory = bound(method, linearised(model))
    assert diverges(method, model, 1.1 * theory) and not diverges(method, model, 0.9 * theory)


@pytest.mark.parametrize(
    "method", [pytest.param(name, marks=[pytest.mark.slow] * (name != "semi_implicit")) for name in EXPLICIT]
)
def test_the_boundary_that_is_sought_is_found_within_a_tenth_of_the_bound(method: str) -> None:
    model = small_body(6.0)
    theory = bound(method, linearised(model))
    assert measured_boundary(method, model, theory) == pytest.approx(theory, rel=0.1)


@pytest.mark.parametrize("z", [0.05, 0.3])
def test_the_limits_of_one_damped_mode_are_those_in_the_words(z: float) -> None:
    mode = np.array([[0.0, 1.0], [-1.0, -2 * z]])
    assert bound("explicit_euler", mode) == pytest.approx(2 * z, rel=0.01)
    assert bound("semi_implicit", mode) == pytest.approx(2 * (math.sqrt(1 + z * z) - z), rel=0.01)


@pytest.mark.parametrize(
    ("method", "z", "share"),
    [("velocity_verlet", 0.0, 1.0), ("velocity_verlet", 0.3, 0.75), ("rk4", 0.0, 1.41), ("rk4", 0.3, 1.9)],
)
def test_the_limits_beside_that_of_semi_implicit_euler_are_those_in_the_words(
    method: str, z: float, share: float
) -> None:
    """Without damping and with it: a quarter less for Verlet, and a factor of 1.4 or 1.9 more for Runge-Kutta."""
    mode = np.array([[0.0, 1.0], [-1.0, -2 * z]])
    assert bound(method, mode) / bound("semi_implicit", mode) == pytest.approx(share, rel=0.03)


def test_tr_bdf2_turns_a_free_body_that_backward_euler_leaves_alone() -> None:
    model, turned = small_body(60_000.0), {}
    for method in ("tr_bdf2", "backward_euler"):
        state = shaken(model)
        move(model, state, method, seconds=0.1, steps=1)
        turned[method] = np.linalg.norm(np.cross(state.positions, model.mass * state.velocities, axis=0).sum(axis=1))
    assert turned["tr_bdf2"] > 1e3 * turned["backward_euler"]


@pytest.mark.parametrize("k", [pytest.param(6.0, marks=pytest.mark.slow), 60_000.0])
@pytest.mark.parametrize("method", UNBOUNDED)
def test_an_implicit_or_sweeping_method_stays_finite_at_any_step(method: str, k: float) -> None:
    model = small_body(k)
    jacobian = linearised(model)
    for dt in (1e-4, 1e-2, 1e-1):
        assert cell(method, model, jacobian, k, dt, steps=16).label != "diverged"


@pytest.mark.parametrize("k", [6.0, 60_000.0])
def test_the_products_own_steps_are_stable(k: float) -> None:
    model = small_body(k)
    substeps, limit = model.substeps(1e-3), bound("semi_implicit", linearised(model))
    assert 1e-3 / substeps < limit
    assert 1e-3 / substeps > min(limit / 4, LONGEST_CONTACT * 0.99)  # and not needlessly short


@pytest.mark.parametrize("steps", [5_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_the_energy_of_verlet_stays_bounded(steps: int) -> None:
    ratios = np.array(energy_trace("velocity_verlet", omega_dt=0.2, steps=steps, samples=500).ratios)
    assert np.abs(ratios - 1).max() == pytest.approx(0.2**2 / 4, rel=0.01)  # it swings by (omega dt)^2 / 4
    assert abs(ratios[-100:].mean() - ratios[:100].mean()) < 1e-3


@pytest.mark.parametrize("omega_dt", [0.05, 0.2, 1.0])
def test_backward_euler_damps_as_theory_says(omega_dt: float) -> None:
    trace = energy_trace("backward_euler", omega_dt=omega_dt, steps=64, samples=64)
    assert artificial_damping(trace) == pytest.approx(backward_euler_damping(omega_dt), rel=0.05)


def test_implicit_midpoint_keeps_the_energy_and_explicit_euler_feeds_it() -> None:
    kept = energy_trace("implicit_midpoint", omega_dt=0.3, steps=100)
    assert max(abs(ratio - 1) for ratio in kept.ratios) < 1e-5
    fed = energy_trace("explicit_euler", omega_dt=0.1, steps=200, samples=50)
    assert artificial_damping(fed) == pytest.approx(-math.log1p(0.01) / 0.2, rel=0.02)
