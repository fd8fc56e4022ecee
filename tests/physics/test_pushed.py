"""A fingertip that is pushed by a force goes in to where the law answers it, and stands still there."""

from dataclasses import replace

import numpy as np
import pytest

from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from studies.scenes import cube
from tests.bodies import ball

RADIUS = 0.0825
NYLON, VINYL, WATER = (preset.material for preset in PRESETS)
TIP = VINYL.indenter.radius


def pinned(material: Material = VINYL, subdivisions: int = 2) -> Model:
    mesh = mesh_from_triangles(*ball(subdivisions, RADIUS))
    return build_model(mesh, [material], pinned=base_vertices(mesh))


def depth_of(material: Material, force: float) -> float:
    """Return the depth [m] at which the law gives a force."""
    depths = np.linspace(0, 3 * material.x0, 100_000)
    return float(np.interp(force, [material.law(each) for each in depths.tolist()], depths))


def test_the_force_may_change_while_it_rests() -> None:
    session = Session(pinned())
    for force in (4.0, 1.0, 12.0, 0.0):
        session.set_fingers([Finger((0.0, 0.0, RADIUS + TIP), TIP, force)])
        frame = session.step(1.0)
        assert frame.depths[0] == pytest.approx(depth_of(VINYL, force), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("backend", ["native", "native64"])
@pytest.mark.parametrize("where", [(0.31, 0.18), (0.1, 0.02)], ids=["aside", "near the middle"])
@pytest.mark.parametrize("cells", [1, 2, 3])
def test_it_stands_still_on_faces_heavier_than_itself(cells: int, where: tuple[float, float], backend: str) -> None:
    size, mesh = PRESETS[2].size, cube(cells, PRESETS[2].size)
    session = Session(build_model(mesh, [WATER], pinned=base_vertices(mesh)), backend=backend)
    session.set_fingers([Finger((where[0] * size, where[1] * size, size / 2 + TIP + 1e-4), TIP, 3.0)])
    session.step(1.0)
    pushes = [session.step(0.001).pushes[0] for _ in range(100)]
    np.testing.assert_allclose(pushes, 3.0, rtol=1e-3)


def test_it_stands_still_on_a_stiff_body() -> None:
    session = Session(pinned(replace(VINYL, K1=50_000, K2=900_000, x0=0.001, k=50_000), 1))
    session.set_fingers([Finger((0.0, 0.0, RADIUS + TIP), TIP, 20.0)])
    session.step(1.0)
    places = [session.step(0.001).touches[0].centre[2] for _ in range(20)]  # type: ignore[union-attr]
    assert np.ptp(places) < 1e-6 and session.frame.finite


def test_it_is_the_same_at_any_frame_rate() -> None:
    fine, coarse = Session(pinned()), Session(pinned())
    for session, steps in ((fine, 120), (coarse, 12)):
        for _ in range(steps):
            session.set_fingers([Finger((0.0, 0.0, RADIUS + TIP), TIP, 3.0)])
            session.step(0.3 / steps)
    assert fine.frame.depths[0] == pytest.approx(coarse.frame.depths[0], abs=1e-6)


@pytest.mark.parametrize("force", [1.0, 5.0])
@pytest.mark.parametrize("material", [NYLON, VINYL, WATER], ids=["nylon", "vinyl", "water"])
def test_a_free_body_on_the_ground_is_pressed_as_deep_as_one_that_is_held(material: Material, force: float) -> None:
    mesh = cube(6, 0.1)
    session = Session(build_model(mesh, [material], gravity=(0.0, 0.0, -9.81), ground=-0.05))
    session.step(0.5)
    session.set_fingers([Finger((0.003, 0.002, float(session.positions()[:, 2].max()) + TIP), TIP, force)])
    session.step(1.5)
    pushes = [session.step(1 / 60).pushes[0] for _ in range(30)]
    np.testing.assert_allclose(pushes, force, rtol=0.01)
    assert session.frame.depths[0] == pytest.approx(depth_of(material, force), rel=0.01)
    assert np.abs(session.positions().mean(axis=0)[:2]).max() < 1e-3, "it stays where it stood"
