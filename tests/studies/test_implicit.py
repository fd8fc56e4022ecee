"""Implicit steps: beyond the explicit limit, free, pressed, and a step without a solution is said to be one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.body.model import build_model
from core.mesh.surface import base_vertices
from studies.charts.work_precision import cases, exact, run
from studies.methods import newton
from studies.methods.energy import energy
from studies.methods.motion import move
from studies.methods.registry import METHODS
from studies.reference.laws import initial_state
from studies.reference.path import FingerPath
from studies.scenes import BALL, FINGERTIP, ball, twisted_ball

IMPLICIT = [name for name, method in METHODS.items() if method.kind == "implicit"]


@pytest.mark.parametrize(("method", "left"), [("backward_euler", 1e-6), ("implicit_midpoint", 0.2)])
def test_an_implicit_step_ten_times_beyond_the_explicit_limit_is_solved(method: str, left: float) -> None:
    """Backward Euler damps what it cannot follow; implicit midpoint rings on with what swings within a step."""
    model, state = twisted_ball(1)
    start = energy(model, state)
    move(model, state, method, seconds=0.05, steps=int(0.05 * model.omega_squared**0.5 / 20))
    assert state.unsolved == 0
    assert energy(model, state) < left * start


@pytest.mark.parametrize("method", IMPLICIT)
def test_implicit_steps_leave_the_momentum_of_a_free_body_alone(method: str) -> None:
    model, state = twisted_ball(1)
    state.velocities += np.array([[0.5], [0], [0]])
    before, centre = state.velocities @ model.mass, state.positions @ model.mass / model.mass.sum()
    move(model, state, method, seconds=0.02, steps=20)
    assert state.velocities @ model.mass == pytest.approx(before, abs=1e-6)
    assert state.positions @ model.mass / model.mass.sum() - centre == pytest.approx([0.01, 0, 0], abs=1e-7)


def test_backward_euler_at_one_step_a_millisecond_meets_the_force_of_ten_small_steps() -> None:
    frictionless = build_model(ball(1), [replace(BALL, friction=0.0)], pinned=base_vertices(ball(1)))
    forces = {}
    for method, substeps in (("semi_implicit", 10), ("backward_euler", 1)):
        state = initial_state(frictionless)
        top = float(state.positions[2].max()) + FINGERTIP
        z = top - 0.010 * np.minimum(np.arange(101) / 50, 1)
        path = FingerPath(centres=np.stack([0 * z, 0 * z, z], axis=1)[None], radii=np.array([FINGERTIP]))
        METHODS[method].run(frictionless, state, path, tick=1e-3, substeps=substeps)
        still = FingerPath(centres=np.repeat(path.centres[:, -1:], 11, axis=1), radii=path.radii)
        impulse = METHODS[method].run(frictionless, state, still, tick=1e-3, substeps=substeps)
        forces[method] = float(impulse[0, 2]) / 0.010
    assert forces["backward_euler"] == pytest.approx(forces["semi_implicit"], rel=0.05)


def test_pressed_by_a_fingertip_implicit_midpoint_rattles_where_backward_euler_is_still() -> None:
    case = next(case for case in cases(quick=False) if case.name == "poke_cube")
    wanted = exact(case)
    rattling, still = (run(case, method, 17, wanted) for method in ("implicit_midpoint", "backward_euler"))
    assert still.error < 0.1
    assert rattling.error > 1.5 * still.error


def test_a_step_that_finds_no_solution_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newton, "NEWTON_STEPS", 1)
    model, state = twisted_ball(1)
    move(model, state, "backward_euler", seconds=0.01, steps=3)
    assert state.unsolved == 3
