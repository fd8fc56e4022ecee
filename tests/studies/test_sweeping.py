"""Methods that sweep, law by law or vertex by vertex: what sweeps must conserve, and where they converge."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from core.base import Floats
from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from studies.methods import vertex_block_descent
from studies.methods.colours import colours
from studies.methods.implicit import run_implicit
from studies.methods.motion import move, relative_error
from studies.methods.registry import METHODS, Run
from studies.reference.laws import State, initial_state
from studies.reference.path import FingerPath
from studies.scenes import BALL, FINGERTIP, ball, twisted_ball

SWEEPING = [name for name, method in METHODS.items() if method.kind == "sweeping"]


def test_items_of_one_colour_share_nothing_and_all_are_coloured() -> None:
    pairs = ball(2).springs
    springs, ends = np.repeat(np.arange(len(pairs)), 2), pairs.ravel()
    for items, uses in ((springs, ends), (ends, springs)):
        found = colours(items, uses)
        assert np.sort(np.concatenate(found)).tolist() == np.unique(items).tolist()
        for colour in found:
            used = uses[np.isin(items, colour)]
            assert len(np.unique(used)) == len(used)


@pytest.mark.parametrize("method", SWEEPING)
def test_sweeps_leave_the_momentum_of_a_free_body_alone(method: str) -> None:
    model, state = twisted_ball(1)
    state.velocities += np.array([[0.5], [0], [0]])
    before, spin = state.velocities @ model.mass, angular_momentum(model, state)
    centre = state.positions @ model.mass / model.mass.sum()
    move(model, state, method, seconds=0.02, steps=20)
    assert state.velocities @ model.mass == pytest.approx(before, abs=1e-9)
    assert state.positions @ model.mass / model.mass.sum() - centre == pytest.approx([0.01, 0, 0], abs=1e-9)
    # it twists: vertices of 0.2 kg swing at about 1 m/s, 8 cm from the middle, and that must not become a turn
    assert np.abs(angular_momentum(model, state) - spin).max() < 0.01 * 0.2 * 1.0 * 0.08


def test_vertex_block_descent_with_enough_sweeps_takes_the_step_of_backward_euler() -> None:
    model, start = twisted_ball(1)
    wanted = move(model, replace_state(start), "backward_euler", seconds=0.005, steps=5)
    errors = {}
    for sweeps in (2, 8, 64):
        run = partial(run_implicit, partial(vertex_block_descent.advance, sweeps=sweeps))
        state, nobody = replace_state(start), FingerPath(centres=np.zeros((0, 6, 3)), radii=np.zeros(0))
        run(model, state, nobody, tick=1e-3, substeps=1)
        errors[sweeps] = relative_error(state.positions, wanted.positions, start.positions)
    assert errors[64] < 0.3 * errors[8] < 0.1 * errors[2]
    assert errors[64] < 1e-3


@pytest.mark.slow
def test_position_based_dynamics_nears_the_equilibrium_as_its_substeps_get_small() -> None:
    model = on_its_base(ball(2), BALL)
    _, wanted = press(model, METHODS["backward_euler"].run, substeps=1)
    errors = {n: abs(press(model, METHODS["xpbd"].run, substeps=n)[1] / wanted - 1) for n in (1, 4, 16)}
    assert errors[16] < 0.03
    # one step a tick is soft by h^2 k w: that is where it fails
    assert errors[1] > 0.2 > 3 * errors[4] > 9 * errors[16]


def test_a_weight_on_compliant_springs_hangs_as_low_at_any_substep() -> None:
    hanging, sag = hung_corner(), {}
    for name, substeps in (("backward_euler", 1), ("xpbd", 4), ("xpbd", 12)):
        state = initial_state(hanging)
        nobody = FingerPath(centres=np.zeros((0, 401, 3)), radii=np.zeros(0))
        METHODS[name].run(hanging, state, nobody, tick=1e-3, substeps=substeps)
        sag[substeps] = state.positions[1, 3] - hanging.matching.rest[1, 3]
    # plain position based dynamics would hang a third as low again at 12 as at 4
    assert sag[4] == pytest.approx(sag[1], rel=0.01)
    assert sag[12] == pytest.approx(sag[1], rel=0.01)


def hung_corner() -> Model:
    """Return a square sheet pinned at three corners, gravity pulling the fourth away from them."""
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, -0.1, 0], [0.1, -0.1, 0.0]])
    mesh = mesh_from_triangles(corners, np.array([[0, 2, 1], [1, 2, 3]]))
    pinned = np.array([True, True, True, False])
    return build_model(mesh, [replace(BALL, fill="none")], pinned=pinned, gravity=(0, -9.81, 0))


def on_its_base(mesh: Mesh, material: Material) -> Model:
    return build_model(mesh, [replace(material, friction=0.0)], pinned=base_vertices(mesh))


def press(model: Model, run: Run, *, substeps: int) -> tuple[State, float]:
    """Press 10 mm deep in 50 ms, wait until all is still; return the state and the force [N] on the fingertip."""
    state, ticks = initial_state(model), 120
    z = float(state.positions[2].max()) + FINGERTIP - 0.01 * np.minimum(np.arange(ticks + 1) / 50, 1)
    centres, radii = np.stack([0 * z, 0 * z, z], axis=1)[None], np.array([FINGERTIP])
    run(model, state, FingerPath(centres=centres[:, :-10], radii=radii), tick=1e-3, substeps=substeps)
    impulse = run(model, state, FingerPath(centres=centres[:, -11:], radii=radii), tick=1e-3, substeps=substeps)
    return state, float(impulse[0, 2]) / 0.010


def angular_momentum(model: Model, state: State) -> Floats:
    return np.cross(state.positions, model.mass * state.velocities, axis=0).sum(axis=1)


def replace_state(state: State) -> State:
    return replace(state, positions=state.positions.copy(), velocities=state.velocities.copy())
