"""Bodies at rest are not stepped, and sleep leaves no trace: what slept goes on as what was kept awake, tick by tick.

The one that is kept awake is given its own state again and again, so that it is never slow for long.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.base import TICK, Floats
from core.body.model import Model, build_model
from core.material import DEFAULT_MATERIAL
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.native.motion import FingertipMotion, Motion
from core.reduction.proxy import build_proxy
from core.session import Finger, Session, step_all
from core.world import Collider, World
from studies import scenes
from studies.motions import straight
from studies.reference import create
from studies.reference.constants import REST_SPEED, ROUNDING
from tests.bodies import ball, plate, sheet

EVERY = ["native64", "native"]
RADIUS, TIP = scenes.BALL_RADIUS, 0.02
TOP = float(scenes.ball(2).rest_positions[:, 2].max())
SIZE = 2 * RADIUS
SETTLED, WATCHED = 2.0, 0.125  # [s] before what wakes it begins, and after
SOFT = replace(scenes.BALL, damping_ratio=0.4)
HELD = 0.006  # [m] how deep a fingertip rests


@dataclass
class Scene:
    """Bodies, the world they meet in if there is one, and the fingertip and colliders there."""

    bodies: list[Session]
    world: World | None = None
    begun: bool = False

    def step(self, seconds: float) -> None:
        if self.world:
            self.world.step(seconds)
        else:
            step_all(self.bodies, [seconds] * len(self.bodies))

    def settle(self, *, awake: bool) -> None:
        for _ in range(round(SETTLED / 0.1)):
            if awake:
                self.stir()
            self.step(0.1)
        assert [body.moved for body in self.bodies] == [awake] * len(self.bodies)

    def stir(self) -> None:
        for body in self.bodies:
            body.body.set_state(body.body.positions(), body.body.velocities())


def on_table(backend: str, slope: float = 0.0) -> Scene:
    """Return a sheet on a table, which friction holds where that is a slope [rad]."""
    turn, (points, faces), (table, squares) = Rotation.from_euler("y", slope), sheet(8, 0.1), sheet(2, 1.0)
    lying = mesh_from_triangles(turn.apply(points + [0, 0, 0.0015]), faces)
    body = Session(build_model(lying, [SOFT], gravity=(0.0, 0.0, -9.81)), backend=backend)
    return Scene([body], World([body], [Collider(turn.apply(table).T.copy(), squares, 0.4)]))


def model(*, level: int = 2, height: float = 0.0, gravity: float = -9.81, free: bool = False) -> Model:
    """Return a ball, pinned at its base where it is neither lifted nor free."""
    mesh = scenes.ball(level)
    if height:
        mesh = mesh_from_triangles(mesh.rest_positions + [0.003, 0.002, height], mesh.triangles)
    pinned = None if height or free else base_vertices(mesh)
    return build_model(mesh, [SOFT], pinned=pinned, gravity=(0.0, 0.0, gravity))


def changed(session: Session, *, k1: float = SOFT.K1, gravity: float = -9.81) -> None:
    before = session.model
    material = replace(SOFT, K1=k1)
    after = build_model(before.mesh, [material], pinned=before.pinned, gravity=(0.0, 0.0, gravity))
    session.change(after)


def alone(backend: str, gravity: float = -9.81) -> Scene:
    return Scene([Session(model(gravity=gravity), backend=backend)])


def proxied(backend: str) -> Scene:
    fine = model(level=3)
    return Scene([Session(fine, proxy=build_proxy(fine, 150), backend=backend)])


def held(backend: str, gravity: float = -9.81) -> Scene:
    """Return a ball that a fingertip presses, and goes on pressing."""
    scene = alone(backend, gravity)
    for depth in np.linspace(0.0, HELD, 25):
        pressed_to(scene, depth)
        scene.step(0.01)
    return scene


def pressed_to(scene: Scene, depth: float, radius: float = TIP) -> None:
    scene.bodies[0].set_fingers([Finger((0.0, 0.0, TOP + radius - depth), radius)])


def under_another(backend: str) -> Scene:
    bodies = [Session(model(height=h, gravity=0.0), backend=backend) for h in (0.0, 2 * RADIUS + 0.01)]
    return Scene(bodies, World(bodies))


def beside_collider(backend: str) -> Scene:
    body, (points, faces) = Session(model(), backend=backend), ball(1, 0.02)
    return Scene([body], World([body], [Collider((points + [0.001, 0.002, RADIUS + 0.3]).T.copy(), faces, 0.4)]))


def pressed(scene: Scene, seconds: float) -> None:
    """A keyframed fingertip comes from afar at 2 m/s and stays 6 mm deep."""
    way = max(0.2 - 2 * seconds, -0.006)
    scene.bodies[0].set_fingers([Finger((0.0, 0.0, TOP + TIP + way), TIP)])


def beside(scene: Scene, seconds: float) -> None:
    """A second fingertip comes from one side, the first rests."""
    first = Finger((0.0, 0.0, TOP + TIP - HELD), TIP)
    scene.bodies[0].set_fingers([first, Finger((RADIUS + TIP - 0.1 * seconds, 0.0, 0.0), TIP)])


def pushed(scene: Scene, _: float) -> None:
    scene.bodies[0].set_fingers([Finger((0.0, 0.0, TOP + TIP), TIP, 3.0)])


def at_begin(change: Callable[[Session], None]) -> Callable[[Scene, float], None]:
    def act(scene: Scene, _: float) -> None:
        if not scene.begun:
            change(scene.bodies[-1])
        scene.begun = True

    return act


def led(session: Session, seconds: float) -> None:
    session.set_pins(session.model.mesh.rest_positions + [0.2 * seconds, 0.0, 0.0])


def bent(session: Session, seconds: float) -> None:
    rest = session.model.mesh.rest_positions
    session.set_rest(rest + np.outer(rest[:, 2] ** 2, [seconds, 0.0, 0.0]) * 4)


def approached(scene: Scene, seconds: float) -> None:
    """A keyframed collider comes from afar at 3 m/s and stays 5 mm deep."""
    assert scene.world
    scene.world.set_colliders([scene.world.colliders[0].positions.T - [0.0, 0.0, min(3 * seconds, 0.285)]])


CAUSES: dict[str, tuple[Callable[[str], Scene], Callable[[Scene, float], None]]] = {
    "a keyframed fingertip": (alone, pressed),
    "a keyframed fingertip, on a proxy": (proxied, pressed),
    "a fingertip pushed by a force": (alone, pushed),
    "a fingertip that rested goes on": (held, lambda scene, seconds: pressed_to(scene, HELD + 0.1 * seconds)),
    "a fingertip that rested is lifted": (held, lambda scene, _: scene.bodies[0].set_fingers([])),
    "a fingertip that rested is gone far away": (held, lambda scene, _: pressed_to(scene, -9.0)),
    "a fingertip that rested grows": (held, lambda scene, _: pressed_to(scene, HELD, 1.5 * TIP)),
    "another fingertip beside one that rests": (held, beside),
    "a changed constant under a fingertip": (held, at_begin(lambda s: changed(s, k1=0.3 * SOFT.K1))),
    "a changed constant": (alone, at_begin(lambda s: changed(s, k1=0.3 * SOFT.K1))),
    "gravity switched on": (lambda b: alone(b, gravity=0.0), at_begin(changed)),
    "gravity switched off": (alone, at_begin(lambda s: changed(s, gravity=0.0))),
    "pins that are let go": (alone, at_begin(lambda s: s.change(model(free=True)))),
    "pins that are led": (alone, lambda scene, seconds: led(scene.bodies[0], seconds)),
    "a rig that bends it": (alone, lambda scene, seconds: bent(scene.bodies[0], seconds)),
    "a body that falls on it": (under_another, at_begin(changed)),
    "a keyframed collider": (beside_collider, approached),
}  # fmt: skip


def act_and_step(scene: Scene, act: Callable[[Scene, float], None], each: float) -> Iterator[Session]:
    """Let what wakes it happen, frame by frame of some time [s]; yield the first body before each and at the end."""
    for frame in range(round(WATCHED / each)):
        yield scene.bodies[0]
        act(scene, (frame + 1) * each)
        scene.step(each)
    yield scene.bodies[0]


def traced(cause: str, backend: str, *, awake: bool, each: float) -> Floats:
    """Return places [m] and velocities [m/s] of the first body, frame by frame (frames, 2, 3, n)."""
    make, act = CAUSES[cause]
    scene = make(backend)
    scene.settle(awake=awake)
    if awake:
        scene.stir()
    return np.array([
        (session.body.positions(), session.body.velocities()) for session in act_and_step(scene, act, each)
    ])  # fmt: skip


@pytest.mark.parametrize("backend", EVERY)
@pytest.mark.parametrize("each", [TICK, 1 / 24], ids=["tick by tick", "frame by frame"])
@pytest.mark.parametrize("cause", CAUSES)
def test_it_goes_on_as_if_it_had_been_awake(cause: str, each: float, backend: str) -> None:
    """Neither place nor velocity has a step that it would not have had, and nothing comes late."""
    slept, awake = (traced(cause, backend, awake=awake, each=each) for awake in (False, True))
    way, off = (np.abs(a).max(axis=(0, 2, 3)) for a in (awake - awake[0], slept - awake))
    assert way[0] > 5e-5
    assert off[0] < 2 * ROUNDING * SIZE
    assert off[1] < 2 * REST_SPEED * SIZE


@pytest.mark.parametrize("backend", EVERY)
def test_a_body_at_rest_is_not_stepped_says_what_it_said_and_sleeps_on_while_it_is_led_nowhere(backend: str) -> None:
    scene = alone(backend, gravity=0.0)
    scene.settle(awake=False)
    body = scene.bodies[0]
    before, velocities, shown = body.body.positions(), body.body.velocities(), body.frame
    pressed_to(scene, -0.0025)  # beside it
    body.set_pins(body.model.mesh.rest_positions)
    after = body.step(0.1)
    assert not body.moved and after.steps == 100
    assert np.array_equal(body.body.positions(), before) and np.array_equal(body.body.velocities(), velocities)
    assert (after.pressure, after.volume) == (shown.pressure, shown.volume)


@pytest.mark.parametrize("backend", EVERY)
def test_what_falls_or_drifts_does_not_sleep(backend: str) -> None:
    for gravity, speed in ((-1e-3, 0.0), (0.0, 1e-4)):  # [m/s2], [m/s]: slower than REST_SPEED for all of the time
        free = build_model(scenes.ball(1), [scenes.BALL], gravity=(0.0, 0.0, gravity))
        body = create(free, backend=backend)
        body.set_state(free.matching.rest, np.full(free.matching.rest.shape, speed))
        for _ in range(3):
            assert body.step(Motion(100, free.substeps(1e-3), 1e-3)).moved
        went = speed * 0.3 + 0.5 * gravity * 0.3**2
        assert (body.positions() - free.matching.rest).mean(axis=1)[2] == pytest.approx(went, rel=0.02)


@pytest.mark.parametrize(("first", "second"), [("native64", "native64"), ("native", "native"), ("numpy", "native64")])
def test_the_same_ticks_sleep_alike_however_they_are_called(first: str, second: str) -> None:
    """It sleeps while the fingertip comes, and is woken in the middle of a call."""
    ball = model(level=1, gravity=0.0)
    one, many = (create(ball, backend=backend) for backend in (first, second))
    top, ticks, steps = float(ball.mesh.rest_positions[:, 2].max()), 350, ball.substeps(1e-3)
    start, end = (0.0, 0.0, top + 0.08), (0.0, 0.0, top + 0.01)
    way = straight(start, end, ticks=ticks, radius=TIP)
    one.step(Motion(ticks, steps, 1e-3, (way,)))
    moved, here = 0, start
    for tick in range(ticks):
        there = tuple(a + (b - a) * tick / (ticks - 1) for a, b in zip(way.first, end, strict=True))
        moved += many.step(Motion(1, steps, 1e-3, (FingertipMotion(here, there, there, TIP),))).moved
        here = there
    assert 250 <= moved < 320
    assert one.positions() == pytest.approx(many.positions(), abs=1e-8)


@pytest.mark.parametrize("backend", EVERY)
def test_nothing_jumps_when_it_falls_asleep(backend: str) -> None:
    """A ball that was pressed and let go comes to rest; tick by tick beside one that is kept awake."""
    bodies = [Session(model(), backend=backend) for _ in range(2)]
    for depth in (0.0, 0.006):
        for body in bodies:
            body.set_fingers([Finger((0.0, 0.0, TOP + TIP - depth), TIP)])
            body.step(0.05)
    ticks_asleep, before = 0, None
    for tick in range(2000):
        for body in bodies:
            body.set_fingers([])
        if tick % 100 == 0:
            bodies[1].body.set_state(bodies[1].body.positions(), bodies[1].body.velocities())
        step_all(bodies, [TICK] * 2)
        (x, v), (awake_x, awake_v) = ((each.body.positions(), each.body.velocities()) for each in bodies)
        assert np.abs(x - awake_x).max() < ROUNDING * SIZE and np.abs(v - awake_v).max() < REST_SPEED * SIZE
        assert bodies[1].moved
        if not bodies[0].moved:
            ticks_asleep += 1
            assert before and np.array_equal(before[0], x) and np.array_equal(before[1], v)
        before = x, v
    assert 500 < ticks_asleep < 1900


@pytest.mark.parametrize("pinned", [True, False], ids=["held at its rim", "on the ground"])
def test_a_proxy_that_rests_shows_a_skin_that_rests_to_the_bit(pinned: bool) -> None:
    """A plate with nine holes, pressed and let go: its steps are so short that rounding swallows some velocities."""
    k, thickness = 48, 0.005
    at = np.arange(k) % 16
    hole = (at > 2) & (at < 13)
    points, faces = plate(~(hole[:, None] & hole), 0.2 / k, thickness)
    rim = (np.abs(points[:, :2] - 0.1) > 0.0999).any(axis=1)
    fine = build_model(
        mesh_from_triangles(points, faces), [DEFAULT_MATERIAL], pinned=rim if pinned else None,
        gravity=(0.0, 0.0, 0.0 if pinned else -9.81), ground=-1e-4,
    )  # fmt: skip
    session = Session(fine, proxy=build_proxy(fine, 800))
    for depth in np.linspace(0.0, thickness, 13):
        session.set_fingers([Finger((0.2 / 3, 0.1, thickness + 0.01 - depth), 0.01)])
        session.step(1 / 60)
    session.set_fingers([])
    for seconds in (1.5, 0.1):
        session.step(seconds)
    assert not session.moved
    shown, proxy = session.positions(), session.body.positions()
    for _ in range(30):
        session.step(1 / 60)
        assert np.array_equal(session.positions(), shown) and np.array_equal(session.body.positions(), proxy)
    session.wake()
    session.step(0.1)
    assert np.abs(session.positions() - shown).max() < 2 * ROUNDING * fine.mesh.size


@pytest.mark.parametrize("backend", EVERY)
def test_under_a_fingertip_that_rests_it_sleeps_and_presses_on_it_as_before(backend: str) -> None:
    slept, awake = held(backend), held(backend)
    slept.settle(awake=False)
    (body,), (other,) = slept.bodies, awake.bodies
    for _ in range(20):
        other.wake()
        awake.step(0.1)
    before = body.body.positions(), body.body.velocities()
    for _ in range(5):
        slept.step(0.1)
        other.wake()
        awake.step(0.1)
        force, goal = (np.array(each.frame.touches[0].impulse) / 0.1 for each in (body, other))
        assert not body.moved and np.array_equal(before, (body.body.positions(), body.body.velocities()))
        assert force == pytest.approx(goal, abs=1e-4 * np.linalg.norm(goal)) and force[2] > 1.0
        assert body.frame.depths[0] == pytest.approx(other.frame.depths[0], rel=1e-6)


@pytest.mark.parametrize("backend", EVERY)
def test_what_lies_on_a_collider_falls_in_the_tick_in_which_that_is_drawn_away(backend: str) -> None:
    scene = on_table(backend)
    scene.settle(awake=False)
    body = scene.bodies[0]
    assert scene.world
    table = scene.world.colliders[0].positions.T
    height = body.body.positions()[2].mean()
    for tick in range(50):
        scene.world.set_colliders([table - [0.0, 0.0, 0.01 * (tick + 1)]])
        scene.step(TICK)
        assert body.moved
    fallen = height - body.body.positions()[2].mean()
    assert fallen == pytest.approx(9.81 * 0.05**2 / 2, rel=0.1)


TURN = 0.3  # [rad]
REMADE: dict[str, tuple[Callable[[World], list[Collider]], float]] = {
    "its collider is taken away": (lambda world: [], 9.81),
    "its collider loses its friction": (lambda world: [world.colliders[0]._replace(friction=0)], 9.81 * np.sin(TURN)),
}


@pytest.mark.parametrize("backend", EVERY)
@pytest.mark.parametrize("change", REMADE)
def test_what_friction_holds_on_a_slope_goes_in_the_tick_after_it_is_no_longer_held(change: str, backend: str) -> None:
    """A world is made anew when an object in it is changed, and the bodies in it may sleep then."""
    scene = on_table(backend, TURN)
    scene.settle(awake=False)
    body = scene.bodies[0]
    before, (colliders, rate) = body.body.positions(), REMADE[change]
    assert scene.world
    scene.world = World(scene.bodies, colliders(scene.world))
    for _ in range(50):
        scene.step(TICK)
        assert body.moved
    gone = np.linalg.norm((body.body.positions() - before).mean(axis=1))
    assert gone == pytest.approx(rate * 0.05**2 / 2, rel=0.1)


@pytest.mark.parametrize("backend", EVERY)
def test_what_slept_in_a_world_falls_out_of_it_once_it_is_woken_from_the_state_it_was_in(backend: str) -> None:
    scene = on_table(backend)
    scene.settle(awake=False)
    body = scene.bodies[0]
    before = body.body.positions(), body.body.velocities()
    body.wake()
    assert np.array_equal(before, (body.body.positions(), body.body.velocities()))
    for _ in range(50):
        body.step(TICK)
        assert body.moved
    assert (before[0] - body.body.positions())[2].mean() == pytest.approx(9.81 * 0.05**2 / 2, rel=0.1)
