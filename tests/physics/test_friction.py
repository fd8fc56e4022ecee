"""Coulomb friction: what it holds stays; what slides is dragged by the coefficient times the push, at any speed."""

from dataclasses import replace

import numpy as np
import pytest

from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from studies.reference.contact import Skin, Step, Touch, resolve
from studies.scenes import cube
from tests.bodies import after

FRICTION = 0.5  # holds up to 26.6 degrees
GRAVITY = 9.81  # [m/s2]
SLOW = pytest.mark.slow


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 3e-3])
@pytest.mark.parametrize(("share", "holds"), [(0.49, True), (0.51, False)])
def test_the_cone_of_friction_is_as_wide_in_long_steps_as_in_short_ones(dt: float, share: float, holds: bool) -> None:
    """A vertex on a fingertip, pushed in by 500 m/s2 and to one side by a share of that; friction 0.5."""
    start = np.array([[0.0], [0.0], [0.01]])
    v = dt * 500.0 * np.array([[share], [0.0], [-1.0]])
    x = start + dt * v
    touch = Touch(
        centre=np.zeros(3), velocity=np.zeros(3), radius=0.01, vertices=np.arange(1), radii=np.zeros(0),
        triangles=np.zeros((0, 3), np.int64),
    )  # fmt: skip
    resolve(x, v, touch, np.ones(1), Skin(np.full(1, FRICTION), np.zeros(1)), Step(dt))
    slid, speed = float(x[0, 0]), 0.0 if holds else 500 * dt * (share - FRICTION)
    assert float(v[0, 0]) == pytest.approx(speed, abs=1e-12) and slid == pytest.approx(dt * speed, abs=1e-12)
    assert np.linalg.norm(x) == pytest.approx(0.01, rel=1e-9), "it is on the fingertip"


def on_a_slope(degrees: float, cells: int) -> Model:
    """Return a cube of 0.1 m on a slope."""
    a = np.radians(degrees)
    down = GRAVITY * np.array([np.sin(a), 0.0, -np.cos(a)])
    vinyl = replace(PRESETS[1].material, friction=FRICTION, spread=0.02)
    return build_model(cube(cells, 0.1), [vinyl], gravity=tuple(down.tolist()), ground=-0.05)


def test_a_body_on_a_slope_beyond_the_angle_of_friction_slides_as_coulomb_says() -> None:
    a = np.radians(35.0)
    wanted = GRAVITY * (np.sin(a) - FRICTION * np.cos(a)) * 0.4**2 / 2
    assert after(Session(on_a_slope(35.0, 1)), 0.4).mean(axis=0)[0] == pytest.approx(wanted, rel=0.15)


@pytest.mark.parametrize("angle", [15.0, 25.0])
@pytest.mark.parametrize("cells", [4, pytest.param(12, marks=SLOW)])
def test_what_friction_holds_does_not_creep_in_ten_seconds_in_which_it_is_kept_awake(angle: float, cells: int) -> None:
    """A body at rest sleeps, which would hide a creep: here each tenth of a second wakes it."""
    session = Session(on_a_slope(angle, cells))
    settled = after(session, 2.0)
    for _ in range(100):
        session.wake()
        session.step(0.1)
        assert np.abs(session.body.velocities()).max() > 0, "it sleeps"
    assert np.abs(session.positions().mean(axis=0) - settled.mean(axis=0)).max() < 1e-5


def test_a_sliding_block_is_slowed_by_the_same_at_any_speed() -> None:
    """From 1 m/s to 10 mm/s, where friction that grows with speed would take ever longer."""
    model = build_model(
        cube(8, 0.1),
        [replace(PRESETS[1].material, friction=FRICTION, damping_ratio=0.8)],
        gravity=(0, 0, -GRAVITY), ground=-0.05,
    )  # fmt: skip
    session = Session(model)
    session.step(0.5)
    moving = np.zeros((3, len(model.mass)))
    moving[0] = 1.0
    session.body.set_state(session.body.positions(), moving)
    speeds = [1.0]
    while speeds[-1] > 0.01 and len(speeds) < 400:
        session.step(0.001)
        speeds.append(float(session.body.velocities()[0] @ model.mass / model.mass.sum()))
    for first, last in ((0.9, 0.7), (0.3, 0.1), (1.0, 0.01)):
        a, b = (int(np.argmax(np.array(speeds) <= wanted)) for wanted in (first, last))
        slowed = (speeds[a] - speeds[b]) / (0.001 * (b - a))
        assert slowed == pytest.approx(FRICTION * GRAVITY, rel=0.05), (first, last)


def dragged(radius: float, depth: float, speed: float, way: float, lead: float) -> tuple[float, float]:
    """Drag a fingertip over a flat face; return drag over push, and the push [N], in the second half of the way.

    Args:
        lead: [m] that it is dragged at 20 mm/s before, until all of the skin slides.
    """
    mesh = cube(20, 0.165)
    material = replace(PRESETS[2].material, friction=FRICTION, damping_ratio=0.5)
    session = Session(build_model(mesh, [material], pinned=base_vertices(mesh)))
    top, at, parts = 0.0825 + radius, -0.03, 40

    def put(x: float, down: float) -> None:
        session.set_fingers([Finger((x, 0.003, top - down), radius)])

    put(at, 0.0)
    session.step(0.001)
    put(at, depth)
    session.step(0.3)
    at += lead
    put(at, depth)
    session.step(lead / 0.02)
    forces = []
    for part in range(1, parts + 1):
        put(at + way * part / parts, depth)
        forces.append(session.step(way / speed / parts).finger_forces[0])
    drag, _, push = np.mean(forces[parts // 2 :], axis=0)
    return float(-drag / push), float(push)


@pytest.mark.parametrize("speed", [1e-4, 1e-3, 1e-2, pytest.param(0.1, marks=SLOW), 1.0])
def test_a_sliding_fingertip_meets_coulombs_friction_at_any_speed(speed: float) -> None:
    """A flat face, from edge to edge: from a tenth of a millimetre to a metre a second. No facet tilts the push."""
    share, push = dragged(0.04, 0.002, speed, 0.001 if speed < 1e-3 else 0.005 if speed < 1e-2 else 0.03, 0.01)
    assert push > 0.5 and share == pytest.approx(FRICTION, rel=1e-6)


def grasped(cells: int) -> tuple[Session, float]:
    """Squeeze a free cube of nylon with three fingertips, lift it 10 cm and hold it; return its height then."""
    size, radius, squeeze = PRESETS[0].size, 0.01, 0.005
    nylon = replace(PRESETS[0].material, friction=FRICTION, spread=0.02)
    model = build_model(cube(cells, size), [nylon], gravity=(0, 0, -GRAVITY), ground=-size / 2)
    session = Session(model)

    def fingers(pressed: float, height: float) -> list[Finger | None]:
        x = size / 2 + radius - pressed
        return [Finger((-x, 0, height), radius), *(Finger((x, y * size, height), radius) for y in (0.2, -0.2))]

    for seconds, pressed, height in ((0.02, 0, 0), (0.1, squeeze, 0), (0.05, squeeze, 0), (0.25, squeeze, 0.1)):
        session.set_fingers(fingers(pressed, height))
        session.step(seconds)
    session.step(0.7)
    return session, height_of(session)


def height_of(session: Session) -> float:
    return float(session.body.positions()[2] @ session.model.mass / session.model.mass.sum())


@pytest.mark.parametrize("cells", [12, pytest.param(24, marks=SLOW), pytest.param(40, marks=SLOW)])
def test_a_grip_holds_as_well_on_a_finer_mesh(cells: int) -> None:
    """866, 3,458 and 9,602 vertices: lifted as high, and in a second it slips by about a tenth of a millimetre."""
    session, height = grasped(cells)
    assert height == pytest.approx(0.1, abs=0.002)
    weight = session.model.mass.sum() * GRAVITY
    carried = session.frame.finger_forces.sum(axis=0)  # at one instant
    assert carried == pytest.approx([0, 0, -weight], abs=0.03 * weight)
    session.step(1.0)
    assert height - height_of(session) < 1.2e-4
    across, along = session.frame.finger_forces[:, 1:], session.frame.finger_forces[:, 0]
    assert (np.linalg.norm(across, axis=1) < 0.9 * FRICTION * np.abs(along)).all(), "it is held inside the cone"
