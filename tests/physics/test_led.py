"""A collider follows its keyframes and the skin gives way, whatever its tessellation and speed."""

import numpy as np
import pytest

from core.body.model import build_model
from core.errors import DimpleError
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.contact.led import MATERIAL, SHAPES, SIDE, lead, shape, soft_cube
from studies.contact.meeting import meeting_of
from tests.bodies import ball, block

BRIDGED = 1.3e-3  # [m] skin touches at 0.7 mm at most, and its edges of 7 mm bridge the 4 mm of the blade


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "suzanne"])
@pytest.mark.parametrize(
    ("speed", "body", "cuts"),
    [
        (0.1, "cube", 1), (1.0, "cube", 2), (1.0, "ball", 1), (1.0, "pillow", 1),
        pytest.param(0.01, "cube", 1, marks=pytest.mark.slow), pytest.param(0.1, "ball", 3, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_a_led_shape_goes_where_it_is_led_with_the_skin_below_it_and_as_hard_however_it_is_cut(
    name: str, speed: float, body: str, cuts: int
) -> None:
    """On the cube without friction: whether a row of its vertices, 6 mm apart, sticks to a side decides a fifth."""
    friction = 0.0 if body == "cube" else 0.4
    whole, cut = (lead(name, count, speed, body, friction) for count in (0, cuts))
    print(whole, cut, sep="\n")
    for led in (whole, cut):
        assert led.late < 1e-12 and led.inside == led.crossing == 0
        assert led.gap < BRIDGED
    assert cut.force == pytest.approx(whole.force, rel=0.05)


def test_a_led_shape_that_skin_cannot_get_away_from_is_held_back_and_that_is_said() -> None:
    session, (start, faces) = soft_cube(12), shape("plate", 0)
    world = World([session], [Collider(start.T.copy(), faces)], itself=[True], names=["Cube", "Plate"])
    for tick in range(1, 121):
        world.set_colliders([start - [0, 0, tick * 1e-3]])
        world.step(1e-3)
        world.check()
    (held,) = world.held
    assert held.name == "Plate" and held.late > 0.01 and world.collider(0)[:, 2].min() > -SIDE
    assert held.said == session.held_note and "no room" in held.said


def test_a_led_shape_that_tore_the_skin_is_said_to_pass_through_until_it_is_apart() -> None:
    session, (start, faces) = soft_cube(12), shape("plate", 0)
    world, torn = World([session], [Collider(start.T.copy(), faces)], names=["Cube", "Plate"]), []
    for tick in [*range(1, 107), *range(106, -40, -2)]:
        world.set_colliders([start - [0, 0, tick * 1e-3]])
        world.step(1e-3)
        torn.append(bool(world.held) and world.held[0].torn and "let go" in session.held_note)
    began = torn.index(True)
    ended = began + torn[began:].index(False)
    assert 90 < began < 106 and 106 + 106 / 2 < ended < 106 + 120 / 2, "until it is above the cube again"
    assert not any(torn[ended:])
    for tick in range(-40, 21):
        world.set_colliders([start - [0, 0, tick * 1e-3]])
        world.step(1e-3)
    assert meeting_of(world).touching and (session.body.positions()[2] < -0.02).sum() > 50, "and then they meet again"


TEN_SPEEDS = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0)  # [m/s]
TORN_BY = {
    "ball": lambda: ball(2, 0.02), "box": lambda: block((0.04, 0.04, 0.04), (0, 0, 0)),
    "blade": lambda: block((0.04, 0.2, 0.004), (0, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "speed"), [*(("ball", speed) for speed in TEN_SPEEDS), ("box", 3.0), ("box", 20.0), ("blade", 10.0)]
)
def test_a_shape_led_through_a_body_lets_go_of_it_and_it_comes_back_to_rest(name: str, speed: float) -> None:
    points, faces = ball(3, 0.0825)
    session = Session(build_model(mesh_from_triangles(points, faces), [MATERIAL], pinned=points[:, 2] < -0.06))
    tip, corners = TORN_BY[name]()
    start = tip + [-0.15, 0.0, 0.02]
    world, most, ticks = World([session], [Collider(start.T.copy(), corners)]), 0.0, round(1.2 / speed / 1e-3)
    torn = False
    for tick in range(1, ticks + 1):
        world.set_colliders([start + [1.2 * tick / ticks, 0, 0]])
        world.step(1e-3)
        torn = torn or any(held.torn for held in world.held)
        most = max(most, float(np.linalg.norm(session.body.positions().T - points, axis=1).max()))
    for _ in range(100):
        world.step(1e-2)
    print(f"{name}, {speed} m/s: skin at most {1e3 * most:.0f} mm from its place, let go: {torn}")
    assert most < 1.05 * 0.165
    assert np.linalg.norm(session.body.positions().T - points, axis=1).max() < 1e-4
    try:
        world.check()
    except DimpleError:
        pytest.fail("they meet again where they are apart")


@pytest.mark.parametrize("mass", [0.5, 2.0, 6.0])
def test_a_falling_box_rests_as_deep_whole_as_cut(mass: float) -> None:
    depths = []
    for cuts in (0, 1, 2):
        start, faces = shape("plate", cuts)
        world = World([soft_cube(16)], [Collider(np.ascontiguousarray(start.T), faces)], masses=[mass])
        world.step(3.0)
        depths.append(-float(world.props[0].state.centre[2]) + 0.005)
    print(f"{mass} kg: {depths} m")
    assert max(depths) < 1.05 * min(depths)
