"""The quasi-static solver: where a pressed body comes to rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.base import DimpleError
from core.body import pressure, shape_matching, springs
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from studies.methods.equilibrium import equilibrium, spheres
from studies.scenes import BALL, BALL_RADIUS, FINGERTIP, ball, cube

RADII = np.array([FINGERTIP])


def pinned_ball(subdivisions: int = 2) -> Model:
    mesh = ball(subdivisions)
    return build_model(mesh, [BALL], pinned=base_vertices(mesh))


def energy(model: Model, positions: np.ndarray) -> float:
    pose = (np.eye(3), np.zeros(3))
    return (
        springs.energy(model.springs, positions)
        + pressure.energy(model.pressure, positions)
        + shape_matching.energy(model.matching, positions, pose)
    )


def test_the_force_on_a_fingertip_is_the_slope_of_the_energy_over_depth() -> None:
    model = pinned_ball(1)
    found, energies = {}, {}
    for depth in (0.0099, 0.0100, 0.0101):
        at = spheres(model, np.array([[0, 0, BALL_RADIUS + FINGERTIP - depth]]), RADII)
        rest = equilibrium(model, at, tolerance=1e-7)
        assert rest.converged
        found[depth], energies[depth] = rest.reactions[0, 2], energy(model, rest.positions)
    slope = (energies[0.0101] - energies[0.0099]) / 0.0002
    # the stiff layer of the contact takes a little of the work
    assert found[0.0100] == pytest.approx(slope, rel=0.05)


def test_a_deep_press_in_one_go_ends_where_a_sweep_ends() -> None:
    model = pinned_ball()
    start, ways = None, []
    for depths in ([0.005, 0.010, 0.015], [0.015]):
        start = None
        for depth in depths:
            at = spheres(model, np.array([[0, 0, BALL_RADIUS + FINGERTIP - depth]]), RADII)
            rest = equilibrium(model, at, start=start)
            assert rest.converged
            start = rest.positions
        ways.append(rest.reactions[0, 2])
    assert ways[0] == pytest.approx(ways[1], rel=1e-3)


def test_an_untouched_body_is_at_rest_at_once() -> None:
    rest = equilibrium(pinned_ball(1), [])
    assert rest.converged
    assert rest.steps == 0


def test_a_stiff_cube_is_pressed_to_its_knee() -> None:
    mesh = cube(6, 0.05)
    model = build_model(mesh, [replace(BALL, k=54_800, fill="air")], pinned=base_vertices(mesh))
    for depth in (0.002, 0.010):
        at = spheres(model, np.array([[0, 0, 0.025 + FINGERTIP - depth]]), RADII)
        rest = equilibrium(model, at)
        assert rest.converged
        assert rest.reactions[0, 2] > 0


def test_gravity_on_a_free_body_has_no_equilibrium_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.methods.equilibrium.STEPS", 6)
    model = build_model(ball(1), [BALL], gravity=(0, 0, -9.81))
    assert not equilibrium(model, []).converged


def test_a_ground_plane_is_refused() -> None:
    with pytest.raises(DimpleError, match="ground"):
        equilibrium(build_model(ball(1), [BALL], ground=0.0), [])
