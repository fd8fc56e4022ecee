"""A fingertip that is dragged over a body: its force does not leap, and where it rests it is that of the press."""

from collections.abc import Iterator

import numpy as np
import pytest

from core.body.model import build_model
from core.material import DEFAULT_MATERIAL
from core.mesh.surface import base_vertices
from core.poke import Hit, Kind, PokeEvent, PokeState, fingers, on_event
from core.session import Session
from studies.primitives import icosphere, sized

RADIUS = 0.0825  # [m] of the ball
START, WAY = -0.03, 0.06  # [m] along its surface, from its top
PRESS_S, REST_S = 0.6, 1.5
SHOWN = 1.15  # times the force of the resting fingertip


@pytest.fixture
def session() -> Session:
    mesh = sized(*icosphere(4), 2 * RADIUS)
    return Session(build_model(mesh, [DEFAULT_MATERIAL], pinned=base_vertices(mesh)))


def on_ball(way: float) -> Hit:
    """Return what the pointer is on after a way [m] from the top."""
    out = np.sin(way / RADIUS), 0.04, np.cos(way / RADIUS)
    normal = tuple((np.array(out) / np.linalg.norm(out)).tolist())
    return Hit(point=tuple(RADIUS * c for c in normal), normal=normal)


def dragged(session: Session, state: PokeState, speed: float, dt: float) -> Iterator[tuple[float, float]]:
    """Press, drag and let rest; yield the time since the drag began [s] and the force [N] of each step."""
    view = tuple(-c for c in on_ball(START).normal)
    state, _ = on_event(state, PokeEvent(kind=Kind.PRESS, hit=on_ball(START), view=view))
    time = -PRESS_S
    while time < WAY / speed + REST_S:
        for share in (0.25, 0.5, 0.75, 1.0):  # of what the pointer goes in a step
            way = START + min(max(speed * (time + share * dt), 0.0), WAY)
            hit = on_ball(way)
            state, _ = on_event(state, PokeEvent(kind=Kind.MOVE, hit=hit, view=tuple(-c for c in hit.normal)))
        state, _ = on_event(state, PokeEvent(kind=Kind.TICK, amount=dt))
        session.set_fingers(fingers(state, 0))
        frame = session.step(dt)
        time += dt
        yield time, float(np.linalg.norm(frame.finger_forces[0]))


@pytest.mark.parametrize("by_force", [False, True], ids=["by depth", "by force"])
@pytest.mark.parametrize("dt", [1 / 60, 0.1], ids=["60 frames a second", "slow frames"])
@pytest.mark.parametrize("speed", [0.1, 0.3, 1.0])
def test_a_dragged_fingertip_shows_no_more_force_than_the_resting_one(
    session: Session, speed: float, dt: float, by_force: bool
) -> None:
    state = PokeState(radius=0.01, depth=0.015, force=9.0, by_force=by_force)
    rows = np.array(list(dragged(session, state, speed, dt)))
    resting = rows[rows[:, 0] <= 0][-1]
    sliding = rows[rows[:, 0] > 0]
    most, rested = sliding[:, 1].max() / resting[1], rows[-1, 1] / resting[1]
    print(f"{speed} m/s, {1 / dt:.0f} frames a second: at most {most:.2f} of the press's force, {rested:.2f} at rest")
    assert sliding[:, 1].max() < SHOWN * resting[1]
    assert rows[-1, 1] == pytest.approx(resting[1], rel=SHOWN - 1)
