"""A still fingertip on a body: the body comes to rest, and stays where it is."""

import numpy as np
import pytest

from core.body.model import build_model
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from tests.bodies import ball

RADIUS, DEPTH = 0.08, 0.01
BACKENDS = ["native", "native64"]


def pressed(tip: float, force: float | None, *, subdivisions: int, backend: str) -> Session:
    """Return a session of a vinyl ball under a fingertip of a radius [m] that stands still, or is pushed [N]."""
    mesh = mesh_from_triangles(*ball(subdivisions, RADIUS))
    session = Session(build_model(mesh, [PRESETS[1].material], pinned=base_vertices(mesh)), backend=backend)
    session.set_fingers([Finger((0.0, 0.0, RADIUS + tip), tip, force)])
    if force is None:
        session.step(0.02)
        session.set_fingers([Finger((0.0, 0.0, RADIUS + tip - DEPTH), tip)])
        session.step(0.1)
    session.step(1.8)
    return session


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("subdivisions", "tip", "force"), [(3, 0.02, 5.0), (3, 0.02, None), (4, 0.02, None), (4, 0.01, None)]
)
def test_a_body_under_a_still_fingertip_comes_to_rest(
    subdivisions: int, tip: float, force: float | None, backend: str
) -> None:
    """It creeps less than a thousandth of the depth in two seconds, and nothing is faster than two tenths of a mm/s."""
    session = pressed(tip, force, subdivisions=subdivisions, backend=backend)
    before, depth = session.skin(), session.frame.depths[0]
    for _ in range(20):
        session.step(0.1)
        assert np.abs(session.body.velocities()).max() < 2e-4
    assert np.linalg.norm(session.skin() - before, axis=1).max() < 1e-3 * depth


def test_what_a_fingertip_rests_on_stays_near_it_when_nothing_moves() -> None:
    """With every velocity zero the skin on the fingertip is still met, and gives its whole force in the next tick."""
    session = pressed(0.02, None, subdivisions=4, backend=BACKENDS[0])
    force = session.frame.finger_forces[0, 2]
    session.body.set_state(session.body.positions())
    assert session.step(0.001).finger_forces[0, 2] == pytest.approx(force, rel=0.01)
