"""A fingertip that is dragged over a body: its force is the law's all along, and the skin glides under it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from core.base import Floats
from core.body.model import build_model
from core.material import DEFAULT_MATERIAL
from core.mesh.surface import base_vertices
from core.poke import Hit, Kind, PokeEvent, PokeState, fingers, on_event
from core.session import Finger, Session
from studies.meshes.simple import icosphere, sized

RADIUS = 0.0825  # [m] of the ball
START, WAY = -0.03, 0.06  # [m] along its surface, from its top
PRESS_S, REST_S = 0.6, 1.5
TIP = DEFAULT_MATERIAL.indenter.radius


@pytest.fixture
def session() -> Session:
    mesh = sized(*icosphere(4), 2 * RADIUS)
    return Session(build_model(mesh, [DEFAULT_MATERIAL], pinned=base_vertices(mesh)))


def on_ball(way: float) -> Hit:
    """Return what the pointer is on after a way [m] from the top."""
    out = np.sin(way / RADIUS), 0.04, np.cos(way / RADIUS)
    normal = tuple((np.array(out) / np.linalg.norm(out)).tolist())
    return Hit(point=tuple(RADIUS * c for c in normal), normal=normal)


def dragged(session: Session, state: PokeState, speed: float, dt: float) -> Iterator[tuple[float, float, float]]:
    """Press, drag and let rest; yield the time since the drag began [s], push [N] and depth [m] of each step."""
    view = tuple(-c for c in on_ball(START).normal)
    state = on_event(state, PokeEvent(kind=Kind.PRESS, hit=on_ball(START), view=view))
    time = -PRESS_S
    while time < WAY / speed + REST_S:
        for share in (0.25, 0.5, 0.75, 1.0):  # of what the pointer goes in a step
            way = START + min(max(speed * (time + share * dt), 0.0), WAY)
            hit = on_ball(way)
            state = on_event(state, PokeEvent(kind=Kind.MOVE, hit=hit, view=tuple(-c for c in hit.normal)))
        state = on_event(state, PokeEvent(kind=Kind.TICK, amount=dt))
        session.set_fingers(fingers(state, 0))
        frame = session.step(dt)
        time += dt
        yield time, frame.pushes[0], frame.depths[0]


@pytest.mark.parametrize("by_force", [False, True], ids=["by depth", "by force"])
@pytest.mark.parametrize("dt", [1 / 60, 0.1], ids=["60 frames a second", "slow frames"])
@pytest.mark.parametrize("speed", [0.1, 0.3, 1.0])
def test_a_dragged_fingertip_is_pushed_by_the_law_all_along(
    session: Session, speed: float, dt: float, by_force: bool
) -> None:
    state = PokeState(radius=TIP, depth=0.015, force=9.0, by_force=by_force)
    rows = np.array(list(dragged(session, state, speed, dt)))
    np.testing.assert_allclose(rows[:, 1], [DEFAULT_MATERIAL.law(depth) for depth in rows[:, 2]], rtol=1e-6)
    time, push, _ = rows.T
    resting, sliding = push[time <= 0][-1], push[time > 0]
    print(f"{speed} m/s, {1 / dt:.0f} frames a second: {sliding.min() / resting:.3f} to {sliding.max() / resting:.3f}")
    assert sliding.max() < 1.02 * resting
    assert push[-1] == pytest.approx(resting, rel=0.01)


@pytest.mark.parametrize("fill", ["air", "solid"])
@pytest.mark.parametrize("friction", [0.5, 1.0])
@pytest.mark.parametrize("depth", [0.006, 0.012])
def test_the_skin_glides_under_a_dragged_fingertip_and_comes_back(depth: float, friction: float, fill: str) -> None:
    """Straight round a ball at 33 mm/s: no vertex sticks and then snaps back, and no face is folded."""
    mesh = sized(*icosphere(4), 2 * RADIUS)
    material = replace(DEFAULT_MATERIAL, friction=friction, fill=fill, K2=2.1 * DEFAULT_MATERIAL.K1)
    session = Session(build_model(mesh, [material], pinned=base_vertices(mesh)))

    def area(x: Floats) -> Floats:
        a, b, c = x[mesh.triangles].transpose(1, 0, 2)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1)

    rest, before = area(mesh.rest_positions), None
    for time in np.arange(-0.5, 2.0, 1 / 60):
        height, turn = RADIUS + TIP - depth * min(1.0, 2 * time + 1), 0.4 * max(time, 0.0) - 0.4
        session.set_fingers([Finger((height * np.sin(turn), 0.004, height * np.cos(turn)), TIP)])
        session.step(1 / 60)
        x = session.positions().astype(float)
        if before is not None:
            assert np.linalg.norm(x - before, axis=1).max() < 0.4 * depth
        assert 0.4 < (area(x) / rest).min()
        before = x
    session.set_fingers([])
    session.step(2.0)
    assert np.abs(session.positions() - mesh.rest_positions).max() < 1e-6
