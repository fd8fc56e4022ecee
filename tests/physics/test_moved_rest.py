"""A body whose shape at rest a rig moves: it goes along, pressed or not, and its own laws stay."""

import numpy as np
import pytest

from core.base import DimpleError, Floats
from core.body.model import Model, build_model
from core.fields import at_rest, depth
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.reduction.proxy import build_proxy
from core.session import Finger, Session
from studies.reference.energy import stored
from tests.bodies import ball
from tests.parity.cases import SIZE, SOFT

LOOK = 1 / 120


def model(subdivisions: int = 2, **options: object) -> Model:
    points, faces = ball(subdivisions)
    mesh = mesh_from_triangles(points * SIZE / np.ptp(points, axis=0).max(), faces)
    return build_model(mesh, [SOFT], **options)  # type: ignore[arg-type]


def turned(rest: Floats, turn: float) -> Floats:
    """Return points (n, 3) [m] turned about the y axis [rad]."""
    c, s = np.cos(turn), np.sin(turn)
    return rest @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def test_a_body_goes_where_its_rig_goes_and_comes_to_rest_in_the_shape_that_it_gives() -> None:
    session = Session(model(rigged=True))
    rest = session.positions().astype(np.float64)
    for look in range(1, 31):
        share = look / 30
        shape = rest * (1, 1 + 0.3 * share, 1) + (0.2 * share, 0, 0)  # wider, and elsewhere
        session.set_rest(shape)
        session.step(LOOK)
    assert np.abs(session.positions() - shape).max() < 0.02 * SIZE  # it is on its way, with its own inertia
    for _ in range(120):
        session.step(LOOK)
    assert np.abs(session.positions() - shape).max() < 1e-4 * SIZE
    assert stored(session.bent_model(), session.body.positions(), (np.eye(3), np.zeros(3))) < 1e-5, "it stores nothing"
    assert np.abs(at_rest(session) - shape).max() < 1e-9 and np.abs(depth(session)).max() < 1e-4 * SIZE
    assert session.frame.rest_volume == pytest.approx(1.3 * session.model.mesh.volume, rel=1e-6)
    assert session.frame.volume == pytest.approx(session.frame.rest_volume, rel=1e-3)


def test_a_rigged_body_that_turns_answers_a_fingertip_as_one_that_stands() -> None:
    forces = []
    for turn in (0.0, 0.7):
        session = Session(model(3, rigged=True))
        rest = session.positions().astype(np.float64)
        for look in range(1, 61):
            session.set_rest(turned(rest, turn * look / 60))
            session.step(LOOK)
        up = turned(np.array([0, 0, 1.0]), turn)
        for look in range(1, 61):
            at = (SIZE / 2 + 0.01 - 0.01 * look / 60) * up
            session.set_fingers([Finger(tuple(at), 0.01)])
            session.step(LOOK)
        for _ in range(60):
            session.step(LOOK)
        forces.append((np.linalg.norm(session.frame.finger_forces[0]), session.frame.depths[0]))
    assert forces[0][0] > 1
    assert forces[1] == pytest.approx(forces[0], rel=0.01)


def test_a_free_body_takes_the_shape_that_its_keys_give_but_stays_where_it_is() -> None:
    session = Session(model())
    rest = session.positions().astype(np.float64)
    for look in range(1, 61):
        session.set_rest(rest * (1, 1 + 0.3 * min(look / 30, 1), 1) + (look / 60, 0, 0))
        session.step(LOOK)
    for _ in range(60):
        session.step(LOOK)
    x = session.positions()
    assert np.ptp(x, axis=0) == pytest.approx(np.ptp(rest * (1, 1.3, 1), axis=0), rel=1e-3)
    assert np.abs(x.mean(axis=0) - rest.mean(axis=0)).max() < 0.01 * SIZE


def test_a_body_that_is_reset_is_as_before_it_was_bent() -> None:
    session = Session(model(pinned=base_vertices(model().mesh), rigged=True))
    fresh = Session(session.model)
    rest = session.positions().astype(np.float64)
    session.set_rest(1.2 * rest)
    session.step(0.05)
    session.reset()
    for each in (session, fresh):
        each.set_fingers([Finger((0, 0, SIZE / 2 + 0.005), 0.01)])
        each.step(0.05)
    assert np.array_equal(session.positions(), fresh.positions())


def test_a_proxy_bends_with_its_rig_and_is_pressed_there_as_its_mesh() -> None:
    body = model(5, rigged=True)
    full, proxied = Session(body), Session(body, proxy=build_proxy(body, 2500))
    rest = full.positions().astype(np.float64)
    for frame in range(20):
        bent = rest * (1, 1, 1 + 0.2 * min(frame / 8, 1))
        top = bent[:, 2].max()
        for session in (full, proxied):
            session.set_rest(bent)
            tip = Finger((0, 0, top + 0.009 - 0.008 * (frame - 10) / 9), 0.01)
            session.set_fingers([tip if frame > 10 else None])
            session.step(1 / 24)
        if frame == 10:
            assert np.abs(proxied.positions() - bent).max() < 1e-3 * SIZE
    assert proxied.proxy
    assert proxied.frame.depths[0] == pytest.approx(full.frame.depths[0], rel=0.02)
    assert proxied.frame.pushes[0] == pytest.approx(full.frame.pushes[0], rel=0.04)
    assert np.abs(proxied.positions() - full.positions()).max() < 0.15 * full.frame.depths[0]


def test_a_shape_at_rest_that_is_none_is_refused() -> None:
    session = Session(model())
    for bad in (np.zeros((3, 3)), np.full((len(session.positions()), 3), np.nan)):
        with pytest.raises(DimpleError):
            session.set_rest(bad)
