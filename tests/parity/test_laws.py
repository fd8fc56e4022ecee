"""The native core does what numpy does: every law, on whole, degenerate and real meshes."""

import numpy as np
import pytest

from core import native
from core.base import Floats
from core.body.model import State
from core.solver import semi_implicit
from studies.methods.registry import Run
from tests.parity.cases import CASES, SIZE, TICK, Case, build

DOUBLE, SINGLE = 1e-9, 1e-4  # of the size


def go(case: Case, run: Run) -> tuple[State, Floats]:
    model, state, path = build(case)
    return state, run(model, state, path, tick=TICK, substeps=model.substeps(TICK))


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize(("run", "tolerance"), [(native.run64, DOUBLE), (native.run, SINGLE)], ids=["f64", "f32"])
def test_positions_forces_and_pressure_are_those_of_numpy(name: str, run: Run, tolerance: float) -> None:
    case = CASES[name]
    expected, pushed = go(case, semi_implicit.run)
    found, felt = go(case, run)
    speed = np.abs(expected.velocities).max() + 1e-3
    assert np.isfinite(expected.positions).all()
    np.testing.assert_allclose(found.positions, expected.positions, rtol=0, atol=tolerance * SIZE)
    np.testing.assert_allclose(found.velocities, expected.velocities, rtol=0, atol=300 * tolerance * speed)
    np.testing.assert_allclose(felt, pushed, rtol=0, atol=100 * tolerance * (np.abs(pushed).max() + 1e-6))
    assert found.pressure == pytest.approx(expected.pressure, rel=100 * tolerance, abs=1e5 * tolerance)


@pytest.mark.parametrize("name", ["paper laws", "paper fill"])
def test_the_vertices_in_contact_are_those_of_numpy(name: str) -> None:
    expected, _ = go(CASES[name], semi_implicit.run)
    found, _ = go(CASES[name], native.run64)
    assert len(expected.contact) or name == "paper fill"  # the pressure blows the skin off the fingertip
    np.testing.assert_array_equal(found.contact, expected.contact)


@pytest.mark.parametrize(("run", "tolerance"), [(native.run64, DOUBLE), (native.run, SINGLE)], ids=["f64", "f32"])
def test_a_fingertip_whose_centre_lies_on_the_skin_pushes_as_with_numpy(run: Run, tolerance: float) -> None:
    model, expected, path = build(CASES["no fill"])
    corners = model.mesh.triangles[np.argmax(model.mesh.rest_positions[model.mesh.triangles].mean(axis=1)[:, 2])]
    path.centres[:] = model.mesh.rest_positions[corners].mean(axis=0)
    found = build(CASES["no fill"])[1]
    few = type(path)(centres=path.centres[:, :2], radii=path.radii)
    for state, stepper in ((expected, semi_implicit.run), (found, run)):
        stepper(model, state, few, tick=TICK, substeps=model.substeps(TICK))
    moved = expected.positions - model.mesh.rest_positions.T
    assert moved[2, corners].max() < -0.1 * path.radii[0]
    np.testing.assert_allclose(found.positions, expected.positions, rtol=0, atol=tolerance * SIZE)


def test_what_is_held_stays_to_the_last_digit() -> None:
    model, state, path = build(CASES["liquid"])
    before = state.positions.copy()
    native.run(model, state, path, tick=TICK, substeps=4)
    np.testing.assert_array_equal(state.positions[:, model.held], before[:, model.held])


def test_a_free_body_far_from_the_origin_moves_as_one_near_it() -> None:
    """Single precision is spent on the body, not on where it is."""
    model, near, path = build(CASES["free"])
    _, far, _ = build(CASES["free"])
    away = np.array([[100.0], [-50.0], [3.0]])
    far.positions += away
    for state in (near, far):
        native.run(model, state, type(path)(centres=path.centres[:0], radii=path.radii[:0]), tick=TICK, substeps=4)
        native.run(model, state, type(path)(centres=np.zeros((0, 21, 3)), radii=np.zeros(0)), tick=TICK, substeps=4)
    np.testing.assert_allclose(far.positions - away, near.positions, rtol=0, atol=1e-6 * SIZE)


def test_a_body_that_has_blown_up_stays_so() -> None:
    model, state, path = build(CASES["liquid"])
    state.velocities[0, 5] = np.nan
    assert (native.run(model, state, path, tick=TICK, substeps=4) == 0).all()
    assert np.isnan(state.positions).any()
