"""Bodies meet colliders, each other and themselves, and nothing passes through anything."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.base import DimpleError
from core.body.model import build_model
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from tests.bodies import ball, sheet

SOFT = Material(K1=600, K2=4000, x0=0.02, k=400, mass=0.15, friction=0.4)
RADIUS = 0.04


def session(
    at: tuple[float, float, float], *, gravity: float = -9.81, level: int = 2, backend: str = "auto"
) -> Session:
    points, faces = ball(level, RADIUS)
    mesh = mesh_from_triangles(points + at, faces)
    return Session(build_model(mesh, [SOFT], gravity=(0, 0, gravity)), backend=backend)


def table(slope: float = 0.0, friction: float = 0.4) -> Collider:
    points, faces = sheet(2, 1.0)
    return Collider(Rotation.from_euler("y", slope).apply(points).T.copy(), faces, friction)


def momentum(body: Session) -> np.ndarray:
    return body.body.velocities() @ body.model.mass


def test_two_bodies_that_collide_keep_their_momentum() -> None:
    sessions = [
        session((0.003, 0, 0), gravity=0, backend="native64"),
        session((0, 0, 0.09), gravity=0, backend="native64"),
    ]
    sessions[1].body.set_state(sessions[1].body.positions(), np.full((3, 162), 0.0) + [[0.0], [0.1], [-1.0]])
    before = sum(momentum(each) for each in sessions)
    world, most = World(sessions), 0
    for _ in range(60):
        most = max(most, world.step(1e-3).touching)
        assert world.meeting.taken == 0
    assert most > 5
    assert np.abs(sum(momentum(each) for each in sessions) - before).max() < 1e-13
    assert abs(momentum(sessions[0])[2]) > 0.05


def test_a_dropped_ball_comes_to_rest_on_a_table_whatever_the_frame_rate() -> None:
    ends = []
    for rate in (24, 60, 120):
        body = session((0.001, 0.002, 0.06))
        world = World([body], [table()])
        for _ in range(rate):
            world.step(1 / rate)
        ends.append(body.positions())
        assert 0 < ends[-1][:, 2].min() < 3e-3
    assert all(np.abs(a - b).max() < 1e-5 for a, b in pairwise(ends))


@pytest.mark.parametrize("speed", [0.5, 5.0])
def test_a_collider_led_through_a_body_passes_neither_the_body_nor_the_table(speed: float) -> None:
    body = session((0.001, 0.002, RADIUS + 1e-3))
    points, faces = ball(1, 0.02)
    start = points + (0, 0, 0.11)
    world = World([body], [table(), Collider(start.T.copy(), faces)])
    for tick in range(1, 101):
        world.set_colliders([None, start - (0, 0, min(speed * tick * 1e-3, 0.11))])
        world.step(1e-3)
        world.check()
    assert body.frame.finite and world.meeting.held_back > 0
    assert body.positions()[:, 2].min() > 0 and world.collider(1)[:, 2].min() > 0


def test_friction_holds_a_body_on_a_slope_up_to_its_cone_and_lets_it_slide_beyond_as_coulomb_says() -> None:
    for slope in (0.3, 0.6):
        down = Rotation.from_euler("y", slope).apply((1, 0, 0))
        points, faces = sheet(8, 0.1)
        lifted = Rotation.from_euler("y", slope).apply(points + (0, 0, 1.3e-3))
        body = Session(
            build_model(
                mesh_from_triangles(lifted, faces), [Material(K1=600, K2=600, x0=0.01, k=400, mass=0.1, friction=0.4)],
                gravity=(0, 0, -9.81),
            )
        )  # fmt: skip
        world = World([body], [table(slope=slope)])
        for _ in range(200):
            world.step(1e-3)
        before = momentum(body) @ down / 0.1
        for _ in range(200):
            world.step(1e-3)
        gained = (momentum(body) @ down / 0.1 - before) / 0.2
        wanted = 9.81 * max(np.sin(slope) - 0.4 * np.cos(slope), 0)
        assert abs(gained - wanted) < 0.02 * 9.81 * 0.4 * np.cos(slope), slope


def test_what_intersects_at_the_start_is_refused_with_its_names_and_its_place() -> None:
    with pytest.raises(DimpleError, match=r'"Ball" and "Table" intersect at \('):
        World([session((0, 0, 0.03))], [table()], names=["Ball", "Table"])


def test_a_body_that_is_far_from_everything_moves_as_if_alone() -> None:
    alone, met = session((0, 0, 1.0)), session((0, 0, 1.0))
    world = World([met], [table()])
    for _ in range(20):
        alone.step(1e-3)
        world.step(1e-3)
    assert np.array_equal(alone.body.positions(), met.body.positions())
