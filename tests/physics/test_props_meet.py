"""Props meet the ground, tables, bowls, hands and each other: `check` refuses what passes through what."""

from collections.abc import Sequence

import numpy as np
import pytest

from core.base import Floats, Ints
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.native.scene import Collider
from core.session import Session
from core.world import World
from studies.contact.meeting import meeting_of, met
from studies.paper_objects import PRESETS
from studies.reference import rigid as turning
from studies.scenes import cube
from tests.bodies import block, sheet

G, SIDE = 9.81, 0.165
Shape = tuple[Floats, Ints]


def soft(cells: int = 3) -> Model:
    """Return a vinyl cube about the origin: where nothing touches it, it only sets how fine contact is."""
    mesh = cube(cells, SIDE)
    return build_model(mesh, [PRESETS[1].material], pinned=base_vertices(mesh))


def table(width: float = 0.6, turn: Sequence[float] = (0.0, 0.0, 0.0)) -> Shape:
    points, faces = sheet(6, width)
    return points @ turning.rotation(np.array(turn)).T + [1.0, 0.0, 0.0], faces


def bowl() -> Shape:
    """Return the lower half of a sphere of 150 mm, open."""
    import trimesh

    ball = trimesh.creation.icosphere(3, 0.15)
    points, faces = np.array(ball.vertices), np.array(ball.faces)
    faces = faces[points[faces][:, :, 2].max(axis=1) < 0.02]
    kept, faces = np.unique(faces, return_inverse=True)
    return points[kept] + [1.0, 0.0, 0.15], faces.reshape(-1, 3)


def meeting(
    led: Sequence[Shape], props: Sequence[Shape], masses: Sequence[float], *, friction: float = 0.5, cells: int = 3,
    **rest: float,
) -> World:  # fmt: skip
    colliders = [Collider(np.ascontiguousarray(x.T), faces, friction) for x, faces in (*led, *props)]
    return World([Session(soft(cells))], colliders, masses=[None] * len(led) + [*masses], **rest)


def seen(world: World, index: int, start: Shape) -> Floats:
    """Return where the vertices (m, 3) of a prop are as they are seen."""
    pose = world.props[index].pose()
    return start[0] @ pose[:3, :3].T + pose[:3, 3]


def test_a_weight_dropped_on_a_table_lands_flat_stands_on_it_and_drifts_nowhere_in_ten_seconds() -> None:
    start = block((0.06, 0.05, 0.03), (1.01, 0.004, 0.045), (0.1, 0.2, 0.3))
    world = meeting([table()], [start], [0.5])
    for _ in range(25):
        world.step(0.02)
        world.check()
    world.step(0.5)
    before = seen(world, 1, start)
    assert before[:, 2].min() == pytest.approx(0.0, abs=1e-6), "as it is seen it stands on the table"
    assert world.props[1].state.centre[2] == pytest.approx(0.015, abs=1e-6)
    for step in range(100):
        world.gravity = np.array([0.0, 0.0, -G * (1 + 1e-9 * (1 - step % 2))])  # another gravity wakes it
        world.step(0.1)
        assert meeting_of(world).touching, "it sleeps, which would hide a drift"
    assert np.abs(seen(world, 1, start) - before).max() < 1e-9
    world.step(1.0)
    world.step(0.1)
    assert meeting_of(world).queries == meeting_of(world).touching == 0, "it sleeps and costs nothing"


@pytest.mark.parametrize("frames", [24, 60, 120])
def test_what_lands_comes_to_rest_at_one_place_whatever_the_frame_rate(frames: int) -> None:
    start = block((0.06, 0.05, 0.03), (1.01, 0.004, 0.06), (0.4, 0.2, 0.3))
    world = meeting([table()], [start], [0.5])
    for _ in range(frames):
        world.step(1 / frames)
    wanted = meeting([table()], [start], [0.5])
    wanted.step(1.0)
    np.testing.assert_array_equal(world.props[1].state.centre, wanted.props[1].state.centre)
    np.testing.assert_array_equal(world.props[1].state.turn, wanted.props[1].state.turn)


@pytest.mark.parametrize(("friction", "degrees"), [(0.5, 26.0), (0.5, 27.2), (0.3, 25.0)])
def test_on_an_inclined_table_a_weight_sticks_or_slides_as_coulomb_says(friction: float, degrees: float) -> None:
    angle = np.deg2rad(degrees)
    tilt, (points, faces) = (0.0, angle, 0.0), block((0.08, 0.08, 0.02), (-0.3, 0.003, 0.0101))
    start = points @ turning.rotation(np.array(tilt)).T + [1.0, 0.0, 0.0], faces
    world = meeting([table(1.2, tilt)], [start], [0.3], friction=friction)
    down = np.array([np.cos(angle), 0, -np.sin(angle)])
    world.step(0.1)
    begun, speed = world.props[1].state.centre, world.props[1].state.velocity @ down
    world.step(0.4)
    wanted = G * (np.sin(angle) - friction * np.cos(angle))
    if wanted < 0:
        assert np.linalg.norm(world.props[1].state.centre - begun) < 1e-6, "it sticks"
    else:
        assert (world.props[1].state.velocity @ down - speed) / 0.4 == pytest.approx(wanted, rel=0.02)
    world.check()


def test_a_weight_that_falls_into_a_bowl_stays_there_and_its_energy_never_grows() -> None:
    start = block((0.05, 0.04, 0.03), (1.06, 0.02, 0.2), (0.3, 0.5, 0.1))
    world, gravity = meeting([bowl()], [start], [0.2], friction=0.3), np.array([0.0, 0.0, -G])
    left = [turning.energy(world.props[1].falling.shape, world.props[1].state, gravity)]
    for _ in range(60):
        world.step(0.02)
        world.check()
        left.append(turning.energy(world.props[1].falling.shape, world.props[1].state, gravity))
    assert (left - np.minimum.accumulate(left)).max() < 1e-8 * left[0]
    assert np.linalg.norm(world.props[1].state.velocity) < 1e-6 and abs(world.props[1].state.centre[2] - 0.02) < 0.005
    world.step(0.5)
    assert meeting_of(world).queries == 0, "it sleeps"


def test_two_weights_stacked_on_a_soft_body_rest_and_press_it_with_both_weights() -> None:
    stack = [block((0.08, 0.07, 0.03), (0.002 * k, 0.001, SIDE / 2 + 0.016 + 0.031 * k)) for k in range(2)]
    world = meeting([], stack, [0.6, 0.4], cells=6)
    world.step(1.5)
    forces = np.mean([met(world, 0.002).forces[:, 2] for _ in range(20)], axis=0)
    assert forces == pytest.approx([-G, 0.6 * G, 0.4 * G], rel=0.005)
    top, bottom = (seen(world, k, stack[k])[np.argsort(stack[k][0][:, 2])] for k in (1, 0))
    assert np.abs(top[:4, 2].mean() - bottom[4:, 2].mean()) < 2e-5, "one stands on the other as they are seen"
    assert max(np.linalg.norm(prop.state.velocity) for prop in world.props.values()) < 1e-3
    world.check()


def test_bars_that_lie_crosswise_hold_each_other() -> None:
    """No vertex of one is near a face of the other."""
    bars = [block((0.16, 0.02, 0.02), (1.0, 0.0, 0.0101)), block((0.02, 0.16, 0.02), (1.0, 0.0, 0.0305))]
    world = meeting([table()], bars, [0.2, 0.2])
    world.step(1.0)
    assert world.props[2].state.centre == pytest.approx([1.0, 0.0, 0.03], abs=1e-5)
    assert meeting_of(world).truncated == 0


def test_what_two_props_give_each_other_is_equal_and_opposite() -> None:
    first = block((0.05, 0.04, 0.03), (1.0, 0.0, 0.0), (0.3, 0.1, 0.2))
    world = meeting([], [first, block((0.05, 0.05, 0.05), (1.08, 0.012, 0.008))], [0.3, 0.2], gravity=(0.0, 0.0, 0.0))
    world.props[0].state.velocity = np.array([0.8, 0.0, 0.0])

    def momentum() -> Floats:
        return np.sum([prop.falling.shape.mass * prop.state.velocity for prop in world.props.values()], axis=0)

    before = momentum()
    for _ in range(20):
        meet = met(world, 0.01)
        np.testing.assert_allclose(meet.forces[1], -meet.forces[2], rtol=0, atol=1e-12)
        np.testing.assert_allclose(meet.moments[1], -meet.moments[2], rtol=0, atol=1e-12)
        world.check()
    assert world.props[1].state.velocity[0] > 0.2 and np.linalg.norm(world.props[1].state.momentum) > 1e-6
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13)


@pytest.mark.parametrize("speed", [0.5, 5.0])
def test_a_keyframed_collider_pushes_a_prop_before_it(speed: float) -> None:
    hand, start = block((0.05, 0.2, 0.1), (0.9, 0.0, 0.052)), block((0.05, 0.05, 0.05), (1.0, 0.005, 0.0251))
    world, tick = meeting([table(1.2), hand], [start], [0.3]), 0.01
    for step in range(1, round(0.2 / speed / tick) + 1):
        ahead = hand[0] + [step * tick * speed, 0, 0]
        world.set_colliders([None, ahead, None])
        world.step(tick)
        world.check()
    assert seen(world, 2, start)[:, 0].min() >= ahead[:, 0].max() - 1e-6
    assert world.props[2].state.velocity[0] == pytest.approx(speed, rel=0.02)


@pytest.mark.parametrize("count", [4, pytest.param(10, marks=pytest.mark.slow)])
def test_a_pile_of_weights_comes_to_rest_and_none_passes_through_another(count: int) -> None:
    rng = np.random.default_rng(1)
    boxes = [
        block((0.05, 0.04, 0.03), [*(0.03 * rng.normal(size=2) + [1.0, 0.0]), 0.05 + 0.06 * k], rng.normal(size=3))
        for k in range(count)
    ]
    world = meeting([table()], boxes, [0.2] * count)
    for _ in range(30):
        world.step(0.05)
        world.check()
    assert max(np.linalg.norm(prop.state.velocity) for prop in world.props.values()) < 1e-6
    assert min(seen(world, k + 1, each)[:, 2].min() for k, each in enumerate(boxes)) > -1e-5


def test_gravity_and_ground_that_change_are_followed_and_wake_what_sleeps() -> None:
    start = block((0.06, 0.05, 0.03), (1.0, 0.0, 0.0151))
    world = meeting([], [start], [0.5], ground=0.0)
    world.step(1.0)
    assert world.props[0].state.centre[2] == pytest.approx(0.015, abs=1e-9)
    world.gravity = np.array([0.0, 0.0, G])
    world.step(0.1)
    assert world.props[0].state.centre[2] == pytest.approx(0.015 + G * 0.1**2 / 2, rel=0.01)
    world.gravity, world.ground = np.array([0.0, 0.0, -G]), None
    world.step(1.0)
    assert world.props[0].state.centre[2] < -1.0
