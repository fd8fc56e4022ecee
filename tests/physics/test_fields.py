"""What is shown in colours on a surface is what the body does there."""

import numpy as np
import pytest

from core import fields
from core.base import Floats
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.reduction.cells import vertex_normals
from core.reduction.proxy import build_proxy
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from tests.bodies import ball

RADIUS, TIP = 0.08, 0.02
VINYL = PRESETS[1].material


def body(**maps: Floats) -> Model:
    mesh = mesh_from_triangles(*ball(3, RADIUS))
    return build_model(mesh, [VINYL], pinned=base_vertices(mesh), **maps)  # type: ignore[arg-type]


def pushed(model: Model, force: float = 5.0, **options: object) -> Session:
    session = Session(model, **options)  # type: ignore[arg-type]
    session.set_fingers([Finger((0.0, 0.0, RADIUS + TIP), TIP, force)])
    session.step(1.8)
    return session


def test_the_pressure_is_nowhere_but_under_the_fingertip() -> None:
    session = pushed(body())
    pressure, skin, mesh = fields.pressure(session), session.skin(), session.model.mesh
    push = pressure * mesh.vertex_areas * vertex_normals(mesh.triangles, skin).T
    below = np.linalg.norm(skin - session.placed[0].position, axis=1) < 1.2 * TIP  # type: ignore[union-attr]
    assert (push[2, below]).sum() > 0.97 * push[2].sum()


def test_the_depth_is_deepest_under_the_fingertip_and_as_deep_as_the_press() -> None:
    session = pushed(body())
    depth = fields.field(session, "depth")
    assert depth.max() == pytest.approx(1e3 * session.frame.depths[0], rel=0.02)
    assert session.skin()[depth.argmax(), 2] > 0.8 * RADIUS


def test_a_free_body_that_moves_as_one_shows_no_depth() -> None:
    model = build_model(mesh_from_triangles(*ball(2, RADIUS)), [VINYL], gravity=(0.0, 0.0, -9.8))
    session = Session(model)
    session.step(0.3)
    assert session.skin()[:, 2].max() < -0.3 and np.abs(fields.field(session, "depth")).max() < 1e-3
    assert np.abs(fields.field(session, "stretch")).max() < 1e-3


def test_a_body_that_is_blown_up_by_a_tenth_is_stretched_by_a_tenth() -> None:
    session = Session(body())
    session.body.set_state(1.1 * session.body.positions())
    np.testing.assert_allclose(fields.field(session, "stretch"), 10.0, rtol=1e-6)


def test_a_proxy_shows_about_the_pressure_of_its_mesh() -> None:
    mesh = mesh_from_triangles(*ball(4, RADIUS))
    model = build_model(mesh, [VINYL], pinned=base_vertices(mesh))
    session = pushed(model, proxy=build_proxy(model, 1000))
    pressure = fields.pressure(session)
    assert len(pressure) == len(mesh.rest_positions)
    whole = (fields.pressure(pushed(model)) * mesh.vertex_areas).sum()
    assert (pressure * mesh.vertex_areas).sum() == pytest.approx(whole, rel=0.25)


@pytest.mark.parametrize("vertices", [0, 300])
def test_a_body_that_lies_in_the_pose_of_its_rig_shows_no_depth_no_stretch_and_no_pressure(vertices: int) -> None:
    mesh = mesh_from_triangles(*ball(3, RADIUS))
    model = build_model(mesh, [VINYL], rigged=True)
    session = Session(model, proxy=build_proxy(model, vertices) if vertices else None)
    bent = session.positions().astype(np.float64) * (1.0, 1.0, 1.3) + (0.1, 0.0, 0.0)
    for _ in range(150):
        session.set_rest(bent)
        session.step(0.01)
    assert np.abs(fields.at_rest(session) - bent[mesh.source]).max() < 1e-6 * RADIUS
    assert np.abs(fields.field(session, "depth")).max() < 0.1
    assert np.abs(fields.field(session, "stretch")).max() < 0.5
    assert fields.pressure(session).max() < 100.0
