"""Fingertips and the ground against the skin: action and reaction, friction, and nothing slips through."""

from dataclasses import replace

import numpy as np
import pytest

from core.base import Floats
from core.body.model import build_model
from core.material import Material, Preset
from core.mesh.surface import Mesh, base_vertices, input_vertices, mesh_from_triangles
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from studies.reference.constants import SUNK
from studies.reference.facets import bulge, met_radius, nearest_on_triangles
from studies.scenes import cube
from tests.bodies import after, ball

SOFT = Material(K1=600, K2=2000, x0=0.02, k=600, mass=0.2, fill="liquid")
BACKENDS = ["native64", "native"]


def winding(x: Floats, mesh: Mesh, point: Floats) -> float:
    """Return how often the skin at x (3, n) winds round a point: 1 inside, 0 outside."""
    corners = x[:, mesh.triangles].transpose(1, 2, 0) - point
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2(np.linalg.det(corners), below).sum() / (2 * np.pi))


def gap(x: Floats, mesh: Mesh, finger: Finger) -> float:
    """Return how far [m] vertices are from a fingertip, and facets from the smaller one they meet; < 0 inside."""
    corners, centre = x[:, mesh.triangles], np.array(finger.position)
    at_rest = bulge(mesh.rest_positions.T[:, mesh.triangles], finger.radius)
    met = met_radius(at_rest, finger.radius, SUNK * finger.radius)
    weights = nearest_on_triangles(corners, centre)
    offset = (corners * weights).sum(axis=2).T - centre
    facets = (np.linalg.norm(offset, axis=1) - met).min()
    return float(min(facets, np.linalg.norm(x.T - centre, axis=1).min() - finger.radius))


@pytest.mark.parametrize("preset", PRESETS, ids=lambda p: p.name)
@pytest.mark.parametrize("cells", [1, 2, 3])
def test_no_fingertip_slips_through_a_face_larger_than_itself(preset: Preset, cells: int) -> None:
    """Press coarse cubes deep with a small fingertip: face centres, edges, corners, off-centre, sliding, sideways."""
    size, mesh = preset.size, cube(cells, preset.size)
    model = build_model(mesh, [preset.material], pinned=base_vertices(mesh))
    depth = 0.036 if size == 0.05 else 0.3 * size
    places = [
        (0, 0, 0, 0, 2),
        (0.49, 0, 0, 0, 2),
        (0.17, 0.17, 0, 0, 2),
        (0.3, -0.11, 0.2, -0.2, 2),
        (0.1, 0.2, 0, 0.1, 0),
    ]
    presses = [(BACKENDS[-1], 0.002, places), (BACKENDS[-1], 0.01, places[3:4])]
    if preset is PRESETS[1] and cells == 2:
        presses.append((BACKENDS[0], 0.01, places[3:4]))
    for backend, radius, some in presses:
        for a, b, slide_a, slide_b, axis in some:
            session = Session(model, backend=backend)
            steps = 50
            for i in range(steps + 1):
                share = i / steps
                way = np.array([a + share * slide_a, b + share * slide_b, 0.5 - share * depth / size]) * size
                way[2] += radius
                finger = Finger(tuple(np.roll(way, axis - 2)), radius)
                session.set_fingers([finger])
                frame = session.step(0.005)
                x = session.positions()[input_vertices(mesh)].T
                assert frame.finite, (a, b, axis, radius)
                assert abs(winding(x, mesh, np.array(finger.position))) < 0.5, (a, b, axis, radius, share)
            assert frame.finger_forces[0, axis] > 0 or (a, b) != (0, 0)  # it may slide off an edge


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_fingertip_in_the_middle_of_a_facet_meets_its_corners_first(backend: str) -> None:
    """Of a flat facet with edges of some 11 mm, a fingertip of 20 mm: 1 mm deep it still touches nothing."""
    mesh = mesh_from_triangles(*ball(3, 0.08))
    model = build_model(mesh, [replace(SOFT, fill="none")], pinned=base_vertices(mesh))
    corners, radius = mesh.rest_positions[mesh.triangles[7]], 0.02
    middle = corners.mean(axis=0)
    distance = float(np.linalg.norm(middle))
    meets = float(radius - np.sqrt(radius**2 - (np.linalg.norm(corners - middle, axis=1) ** 2).min()))
    assert 0.5e-3 < meets < 2e-3
    moved = []
    for deep in (0.8 * meets, 1.2 * meets):
        session = Session(model, backend=backend)
        session.set_fingers([Finger(tuple((distance + radius - deep) * middle / distance), radius)])
        session.step(0.001)
        moved.append(float(np.abs(session.body.positions() - model.matching.rest).max()))
    assert moved[0] < 1e-8 and moved[1] > 1e-6


def test_a_fingertip_does_not_part_what_it_presses() -> None:
    """Object 2 of the samples, without friction: beyond its knee vertices flee the fingertip by metres a second.

    Its facets are small beside the fingertip, and still hold it when their corners are gone.
    """
    preset = PRESETS[1]
    mesh, tip = cube(34, preset.size), preset.material.indenter
    session = Session(build_model(mesh, [replace(preset.material, friction=0.0)], pinned=base_vertices(mesh)))
    for way in np.linspace(0, 0.024, 400):
        finger = Finger((0.0165, -0.0198, preset.size / 2 + tip.radius - float(way)), tip.radius)
        session.set_fingers([finger])
        frame = session.step(0.001)
        assert frame.finite and abs(winding(session.body.positions(), mesh, np.array(finger.position))) < 0.5
    assert frame.finger_forces[0, 2] > 10


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_skin_stays_out_of_the_fingertip(backend: str) -> None:
    mesh = mesh_from_triangles(*ball(1, 0.08))
    session = Session(build_model(mesh, [SOFT], pinned=base_vertices(mesh)), backend=backend)
    for i in range(31):
        finger = Finger((0.0, 0.0003 * i, 0.1 - 0.0007 * i), 0.02)
        session.set_fingers([finger])
        session.step(0.004)
        assert gap(session.body.positions(), mesh, finger) > -0.02 * finger.radius
    assert gap(session.body.positions(), mesh, finger) < 1e-3 * finger.radius


def test_the_ground_stops_and_holds_a_falling_body() -> None:
    mesh = mesh_from_triangles(*ball(1, 0.05))
    model = build_model(mesh, [replace(SOFT, damping_ratio=0.6)], gravity=(0, 0, -9.81), ground=-0.1)
    session = Session(model)
    lowest = [after(session, 0.02)[:, 2].min() for _ in range(40)]
    assert min(lowest) > -0.1 - 1e-6
    assert session.positions()[:, 2].min() == pytest.approx(-0.1, abs=1e-4)
    still = session.positions()
    np.testing.assert_allclose(after(session, 0.1), still, atol=2e-3)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_fingertip_that_jumps_far_does_not_blow_the_body_up(backend: str) -> None:
    mesh = mesh_from_triangles(*ball(1, 0.08))
    session = Session(build_model(mesh, [SOFT], pinned=base_vertices(mesh)), backend=backend)
    rng = np.random.default_rng(0)
    for _ in range(12):
        session.set_fingers([Finger(tuple(rng.normal(0, 0.06, 3)), 0.02), Finger(tuple(rng.normal(0, 2, 3)), 0.01)])
        frame = session.step(0.008)
        assert frame.finite
    session.set_fingers([])
    np.testing.assert_allclose(after(session, 1.5), mesh.rest_positions, atol=2e-3)
