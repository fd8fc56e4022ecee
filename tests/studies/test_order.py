"""Each method converges at its own order: against a closed form, and against a solver that is not ours."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from core.body.model import Model
from studies.methods.motion import move, relative_error, right_hand_side
from studies.methods.registry import METHODS
from studies.reference.laws import State
from studies.scenes import oscillator, oscillator_radius, twisted_ball

WITHIN = 0.15
# steps of the coarser run: fine enough for the leading term, coarse enough to stay above rounding
OSCILLATOR_STEPS = {1: 75, 2: 50, 4: 25}
BALL_STEPS = {1: 400, 2: 80, 4: 60}
BALL_STEPS_IMPLICIT = {1: 180, 2: 40}  # no limit asks for more
BALL_STEPS_SWEEPING = {1: 250}


def observed_order(model: Model, start: State, method: str, wanted: np.ndarray, seconds: float, steps: int) -> float:
    errors = []
    for count in (steps, 2 * steps):
        end = move(model, copy.deepcopy(start), method, seconds=seconds, steps=count)
        errors.append(relative_error(end.positions, wanted, start.positions))
    assert errors[1] > 1e-11, "rounding hides the order: take fewer steps"
    return float(np.log2(errors[0] / errors[1]))


@pytest.mark.parametrize(
    ("method", "damping_ratio"),
    # what is damped has every term; without damping the methods with a cheap step do for every run
    [
        pytest.param(name, ratio, marks=[pytest.mark.slow] * (ratio == 0 and method.kind != "explicit"))
        for name, method in METHODS.items()
        for ratio in (0.0, 0.3)
    ],
)
def test_a_breathing_triangle_follows_its_closed_form_at_the_order_of_the_method(
    method: str, damping_ratio: float
) -> None:
    model, start = oscillator(damping_ratio=damping_ratio)
    seconds, order = 0.024, METHODS[method].order  # no leading error happens to be 0 then
    radius = oscillator_radius(model, seconds)
    wanted = start.positions * radius / np.linalg.norm(start.positions[:, 0])
    found = observed_order(model, start, method, wanted, seconds, OSCILLATOR_STEPS[order])
    assert found == pytest.approx(order, abs=WITHIN)


@pytest.fixture(scope="module")
def ball_in_flight() -> tuple[Model, State, np.ndarray, float]:
    seconds = 0.002
    model, start = twisted_ball(1, amount=0.3)
    y = np.concatenate([start.positions.ravel(), start.velocities.ravel()])
    answer = solve_ivp(right_hand_side(model), (0, seconds), y, method="DOP853", rtol=1e-10, atol=1e-13)
    return model, start, answer.y[: start.positions.size, -1].reshape(3, -1), seconds


SLOW = {"vertex_block_descent", "backward_euler", "explicit_euler"}  # of order 1 they take the most steps


@pytest.mark.parametrize("method", [pytest.param(m, marks=[pytest.mark.slow] * (m in SLOW)) for m in METHODS])
def test_a_twisted_ball_converges_on_an_independent_solver_at_the_order_of_the_method(
    method: str, ball_in_flight: tuple[Model, State, np.ndarray, float]
) -> None:
    model, start, wanted, seconds = ball_in_flight
    order = METHODS[method].order
    by_kind = {"explicit": BALL_STEPS, "implicit": BALL_STEPS_IMPLICIT, "sweeping": BALL_STEPS_SWEEPING}
    steps = by_kind[METHODS[method].kind][order]
    assert observed_order(model, start, method, wanted, seconds, steps) == pytest.approx(order, abs=WITHIN)
