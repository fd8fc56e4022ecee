"""What is put down comes to rest and stays there: a ball on a table, a ball on another ball."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.body.model import build_model
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from tests.bodies import ball, sheet

SOFT = Material(K1=600, K2=4000, x0=0.02, k=400, spread=0.02, mass=0.15, friction=0.4)
RADIUS = 0.04
SETTLED, WATCHED = 5, 10  # [s]


def turned_ball(level: int, turn: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    points, faces = ball(level, RADIUS)
    return Rotation.from_euler("xyz", turn).apply(points), faces


def session(points: np.ndarray, faces: np.ndarray, *, pinned: np.ndarray | None = None) -> Session:
    return Session(build_model(mesh_from_triangles(points, faces), [SOFT], gravity=(0, 0, -9.81), pinned=pinned))


def drift(world: World, body: Session) -> float:
    """Return how far any vertex goes in ten seconds [m], after the body has come to rest."""
    world.step(SETTLED)
    before, most = body.body.positions(), 0.0
    for _ in range(WATCHED):
        world.step(1.0)
        most = max(most, float(np.abs(body.body.positions() - before).max()))
    return most


@pytest.mark.parametrize("turn", [(0.3, 0.5, 0.2), (1.0, 0.1, 0.7)])
def test_a_ball_on_a_table_stops_rocking_and_stays(turn: tuple[float, float, float]) -> None:
    points, faces = turned_ball(2, turn)
    body = session(points + (0.001, 0.002, RADIUS + 0.003), faces)
    flat, squares = sheet(2, 1.0)
    assert drift(World([body], [Collider(flat.T.copy(), squares, 0.4)]), body) < 1e-5


@pytest.mark.parametrize("off", [pytest.param(0.0, marks=pytest.mark.slow), 0.0002])
def test_a_ball_at_rest_on_another_drifts_by_about_a_tenth_of_a_millimetre_in_ten_seconds(off: float) -> None:
    low, faces = turned_ball(3, (0.3, 0.5, 0.2))
    high, _ = turned_ball(3, (0.1, 0.2, 0.9))
    pinned = session(low, faces, pinned=low[:, 2] < -0.5 * RADIUS)
    body = session(high + (off, 0, low[:, 2].max() - high[:, 2].min() + 1e-3), faces)
    moved = drift(World([pinned, body]), body)
    assert moved < 1.2e-4
    assert body.body.positions()[2].mean() > 1.8 * RADIUS, "it has not rolled off"


def test_a_ball_beside_the_top_of_another_rolls_off() -> None:
    low, faces = turned_ball(3, (0.3, 0.5, 0.2))
    pinned = session(low, faces, pinned=low[:, 2] < -0.5 * RADIUS)
    body = session(low + (0.008, 0, 2 * RADIUS), faces)
    world = World([pinned, body])
    world.step(2.0)
    assert body.body.positions()[2].mean() < 0


def test_what_lies_on_a_table_sleeps_with_what_lies_on_it_and_wakes_where_it_was() -> None:
    flat, squares = sheet(8, 0.1)
    sheets = [session(flat + (0, 0, height), squares) for height in (0.003, 0.006)]
    table = sheet(2, 1.0)
    world = World(sheets, [Collider(table[0].T.copy(), table[1], 0.4)])
    world.step(3.0)
    world.step(1.0)
    assert not any(body.moved for body in sheets)
    before = [body.body.positions() for body in sheets]
    world.step(1.0)
    assert all(np.array_equal(a, body.body.positions()) for a, body in zip(before, sheets, strict=True))
    world.set_colliders([table[0] + (1e-5, 0, 0)])
    world.step(1e-3)
    assert all(body.moved for body in sheets)
    assert max(np.abs(a - body.body.positions()).max() for a, body in zip(before, sheets, strict=True)) < 2e-5


def test_a_body_that_slept_is_hit_as_if_it_had_been_awake() -> None:
    ends = []
    for kept_awake in (False, True):
        points, faces = turned_ball(2, (0.3, 0.5, 0.2))
        bodies = [
            Session(build_model(mesh_from_triangles(points + (0, 0, height), faces), [SOFT]), backend="native64")
            for height in (0.0, 2 * RADIUS + 0.08)
        ]
        bodies[1].body.set_state(bodies[1].body.positions(), np.full((3, 162), [[0.0], [0.02], [-0.2]]))
        world, slept = World(bodies), 0
        for tick in range(600):
            if kept_awake and tick < 300:
                bodies[0].body.set_state(bodies[0].body.positions(), bodies[0].body.velocities())
            world.check()  # a query at the same ticks in both: when one is, shifts a hit by some micrometres
            world.step(1e-3)
            slept += not bodies[0].moved
        assert (slept == 0) == kept_awake
        ends.append([body.body.positions() for body in bodies])
    assert np.abs(ends[0][0] - ends[0][1]).max() > 0.01
    assert all(np.abs(a - b).max() < 1e-12 for a, b in zip(*ends, strict=True))
