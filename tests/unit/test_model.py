"""What a model makes of a mesh and its materials."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.body.model import build_model
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from studies import scenes
from studies.paper_objects import PRESETS
from studies.reference.laws import initial_state
from tests.bodies import Shape, ball, hemisphere

SOFT = Material(K1=610, K2=7230, x0=0.0163, k=600, mass=0.2)


def sliver_ball() -> tuple[np.ndarray, np.ndarray]:
    """Return a ball with one vertex drawn close to a neighbour."""
    ball = scenes.ball(2)
    x, (i, j) = ball.rest_positions.copy(), ball.springs[40]
    x[i] += 0.97 * (x[j] - x[i])
    return x, ball.triangles


def test_an_even_mesh_keeps_its_mass_where_its_area_is():
    mesh = scenes.ball(2)
    mass = build_model(mesh, [SOFT]).mass
    np.testing.assert_allclose(mass, 0.2 * mesh.vertex_areas / mesh.vertex_areas.sum(), rtol=0.02)


@pytest.mark.parametrize("pinned", [None, "base"])
def test_the_body_weighs_what_its_material_says_slivers_or_not(pinned):
    x, triangles = sliver_ball()
    mesh = mesh_from_triangles(x, triangles)
    pins = None if pinned is None else x[:, 2] < x[:, 2].min() + 0.02
    assert build_model(mesh, [SOFT], pinned=pins).mass.sum() == pytest.approx(0.2, rel=1e-12)


def test_a_sliver_moves_under_two_percent_of_the_mass_and_does_not_multiply_the_steps():
    x, triangles = sliver_ball()
    uneven, even = build_model(mesh_from_triangles(x, triangles), [SOFT]), build_model(scenes.ball(2), [SOFT])
    by_area = 0.2 * uneven.mesh.vertex_areas / uneven.mesh.vertex_areas.sum()
    assert np.abs(uneven.mass - by_area).sum() / 2 < 0.02 * 0.2
    assert uneven.substeps(1e-3) <= 3 * even.substeps(1e-3)


def turns(shape: Shape, fill: str = "solid", **options: Any) -> list[float]:
    """Return the inertia of a body over that of its skin, about its principal axes."""
    model = build_model(mesh_from_triangles(*shape), [replace(SOFT, fill=fill)], **options)
    return sorted((1 + np.linalg.eigvals(model.fill_momentum).real).tolist())


def test_a_free_solid_has_the_inertia_of_its_volume_and_what_is_held_or_has_another_fill_that_of_its_skin() -> None:
    (points, faces), long = ball(4, 0.08), np.array([1.0, 1.0, 10.0])
    assert turns((points, faces)) == pytest.approx([0.6] * 3, rel=0.01)
    assert turns((points * long, faces))[0] == pytest.approx(0.5, abs=0.04)  # a rod about its axis
    assert turns((points, faces), "liquid") == turns((points, faces), "air") == [1.0] * 3
    assert turns((points, faces), pinned=points[:, 2] > 0.079) == [1.0] * 3


def test_a_solid_with_a_hole_turns_as_if_it_were_closed() -> None:
    points, faces = ball(4, 0.08)
    whole = turns((points, faces[points[faces].mean(axis=1)[:, 2] < 0.0799]))
    half, closed = hemisphere(64, 16, 0.08), turns(hemisphere(64, 16, 0.08))
    assert whole == pytest.approx([0.6] * 3, rel=0.02)
    turned = turns((half[0] @ np.diag([1.0, -1.0, -1.0]) + (0.5, 0.2, 0.1), half[1]))
    assert turned == pytest.approx(closed, rel=1e-6)


def test_a_density_and_the_mass_it_makes_give_the_same_body():
    mesh = scenes.cube(6, 0.165)
    water = PRESETS[2].material
    by_mass = Material(
        K1=water.K1, K2=water.K2, x0=water.x0, k=water.k, mass=1000 * mesh.volume, fill=water.fill
    )  # fmt: skip
    np.testing.assert_allclose(build_model(mesh, [water]).mass, build_model(mesh, [by_mass]).mass, rtol=1e-12)
    assert build_model(mesh, [water]).mass.sum() == pytest.approx(1000 * 0.165**3, rel=1e-9)


def test_two_materials_share_a_mesh_by_the_area_of_their_faces():
    mesh = scenes.cube(6, 0.1)
    top = mesh.rest_positions[mesh.triangles][:, :, 2].mean(axis=1) > 0.0
    both = mesh_from_triangles(mesh.rest_positions, mesh.triangles, triangle_material=top.astype(int))
    heavy = Material(K1=610, K2=7230, x0=0.0163, k=600, mass=0.6)
    assert build_model(both, [SOFT, heavy]).mass.sum() == pytest.approx(0.4, rel=1e-9)


def test_a_body_that_moves_leaves_its_rest_shape_alone() -> None:
    """Also where the positions came column by column, which numpy does not copy when it turns them."""
    made = scenes.ball(1)
    points, faces = made.rest_positions, made.triangles
    model = build_model(mesh_from_triangles(np.asfortranarray(points), faces), [SOFT])
    state = initial_state(model)
    state.positions += 1.0
    np.testing.assert_array_equal(model.mesh.rest_positions, points)
    np.testing.assert_array_equal(model.matching.rest, points.T)


@pytest.mark.parametrize("depth", [0.001, 0.08])
def test_a_body_that_starts_below_the_ground_is_not_flung_out(depth: float) -> None:
    """As a sphere added at the origin of a scene with a floor; it stays where it is, and a note says so."""
    mesh = scenes.ball(2)
    bottom = float(mesh.rest_positions[:, 2].min())
    model = build_model(mesh, [scenes.BALL], gravity=(0, 0, -9.81), ground=bottom + depth)
    assert model.ground == bottom and f"{1e3 * depth:.3g} mm below the ground" in " ".join(model.notes)
    session = Session(model)
    for _ in range(10):
        session.step(0.1)
        assert abs(session.positions()[:, 2].mean()) < 0.01
    above = build_model(mesh, [scenes.BALL], gravity=(0, 0, -9.81), ground=bottom)
    assert above.ground == bottom and "ground" not in " ".join(above.notes)
