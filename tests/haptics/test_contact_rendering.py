"""What a device renders of a running session: the measured law."""

from dataclasses import replace

import numpy as np
import pytest

from core.body.model import build_model
from core.haptics.contact_model import Contact, force_at, wall_slope
from core.haptics.contact_rendering import ContactRendering, Workspace, rendered
from core.material import FINGERTIP, PRESETS
from core.mesh.surface import base_vertices
from core.session import Finger, Session
from studies import scenes

CAP = 1e4  # [N/m] of a device that renders all
RADIUS = 0.01
MATERIAL = PRESETS[1].material  # vinyl and air: K1 = 610 N/m
SOLID = replace(MATERIAL, K1=600.0, K2=1350.0, x0=0.006, fill="solid", indenter=FINGERTIP)
TOP = PRESETS[1].size / 2 + RADIUS
TURN = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # a quarter round z


@pytest.fixture(scope="module")
def session() -> Session:
    mesh = scenes.cube(6, PRESETS[1].size)
    return Session(build_model(mesh, [MATERIAL], pinned=base_vertices(mesh)))


def contacts(session: Session, place: Workspace, cap: float, now: float) -> tuple[Contact | None, ...]:
    return ContactRendering().contacts(session, place, cap, now)


def press(session: Session, depth: float) -> None:
    session.reset()
    session.set_fingers([Finger((0.0, 0.0, TOP), RADIUS)])
    session.set_fingers([Finger((0.0, 0.0, TOP - depth), RADIUS)])
    session.step(0.1)


@pytest.mark.parametrize("depth", [0.001, 0.005, 0.012])
def test_the_rendered_force_is_the_measured_law(session: Session, depth: float) -> None:
    press(session, depth)
    (contact,) = contacts(session, Workspace(), CAP, 0.0)
    assert contact and contact.normal == pytest.approx((0, 0, 1), abs=1e-9)
    assert contact.k_n == MATERIAL.K1
    assert contact.force[2] == pytest.approx(MATERIAL.K1 * depth, rel=0.01)
    assert np.hypot(*contact.force[:2]) < 0.02 * contact.force[2]


def test_beyond_the_knee_it_is_k2(session: Session) -> None:
    press(session, 0.020)
    (contact,) = contacts(session, Workspace(), CAP, 0.0)
    assert contact and contact.k_n == MATERIAL.K2
    assert contact.force[2] == pytest.approx(MATERIAL.law(0.020), rel=0.01)


def test_what_the_device_cannot_render_is_rendered_as_steep_as_it_can(session: Session) -> None:
    press(session, 0.020)
    (contact,) = contacts(session, Workspace(), 640.0, 0.0)
    assert contact and contact.k_n == 640.0
    assert contact.force[2] == pytest.approx(610 * 0.0163 + 640 * (0.020 - 0.0163), rel=0.01)
    softer = rendered(MATERIAL, 640.0)
    assert (softer.K1, softer.K2) == (610.0, 640.0)


def test_of_a_solid_the_rendered_law_is_softer_everywhere_and_no_steeper_than_the_cap() -> None:
    """With other slopes it would begin with another power, and harder."""
    depths = np.linspace(0, 4 * SOLID.x0, 400)
    for cap in (1300.0, 800.0, 300.0):
        softer = rendered(SOLID, cap)
        forces, law = (np.array([each.law(depth) for depth in depths]) for each in (softer, SOLID))
        assert (forces <= law + 1e-12).all() and softer.power == pytest.approx(SOLID.power)
        assert np.diff(forces).max() <= cap * depths[1] * (1 + 1e-9)
    assert rendered(SOLID, CAP) == SOLID


def test_a_wall_of_a_solid_gives_no_more_than_it_took() -> None:
    """Whatever the frames: with K1 up to the knee it would give a fifth of a mJ each time."""
    frame = 1 / 60
    for middle, way, rate in ((0.004, 0.0015, 3), (0.005, 0.0008, 5), (0.003, 0.003, 2), (0.007, 0.002, 3.3)):
        t = np.linspace(0, 20 / rate, 60_001)  # twenty times
        x, seen = (middle + way * np.sin(2 * np.pi * rate * at) for at in (t, frame * np.floor(t / frame)))
        law, slope = np.array([(SOLID.law(depth), wall_slope(SOLID, depth)) for depth in seen]).T
        forces = np.maximum(law + slope * (x - seen), 0)
        assert -float(((forces[1:] + forces[:-1]) / 2) @ np.diff(x)) / 20 < 1e-5, "[J]"


def test_two_frames_of_one_press_tell_the_same_curve(session: Session) -> None:
    """So a new contact changes nothing while the knee is not passed: the simulation's rate does not matter."""
    press(session, 0.004)
    (before,) = contacts(session, Workspace(), CAP, 0.0)
    press(session, 0.009)
    (after,) = contacts(session, Workspace(), CAP, 0.0)
    assert before and after
    assert force_at(before, after.at, CAP)[2] == pytest.approx(after.force[2], rel=1e-3)


def test_clear_of_the_body_the_gap_is_known(session: Session) -> None:
    press(session, -0.003)
    (contact,) = contacts(session, Workspace(), CAP, 0.0)
    assert contact and contact.gap == pytest.approx(0.003, abs=1e-5) and contact.force == (0, 0, 0)
    touched = (contact.at[0], contact.at[1], contact.at[2] - 0.005)
    assert force_at(contact, touched, CAP)[2] == pytest.approx(MATERIAL.K1 * 0.002, rel=0.01)


def drag(session: Session, rendering: ContactRendering, ways: list[float]) -> list[Contact]:
    """Press 10 mm deep, then go to places along x [m]."""
    press(session, 0.010)
    out = []
    for x in [0.0, *ways]:
        session.set_fingers([Finger((x, 0.0, TOP - 0.010), RADIUS)])
        session.step(0.05)
        (contact,) = rendering.contacts(session, Workspace(), CAP, 0.0)
        assert contact
        out.append(contact)
    return out


def test_sideways_a_fingertip_sticks_then_slips() -> None:
    """A spring of 2/3 K1 up to half the push (friction 0.5), then no more; turned round it lets go and pulls back."""
    mesh = scenes.cube(6, PRESETS[1].size)
    session = Session(build_model(mesh, [MATERIAL], pinned=base_vertices(mesh)))
    _, stick, slip, back = (c.force for c in drag(session, ContactRendering(), [0.004, 0.020, 0.016]))
    push, k = MATERIAL.K1 * 0.010, 2 / 3 * MATERIAL.K1
    assert stick[0] == pytest.approx(-k * 0.004, rel=0.03)
    assert slip[0] == pytest.approx(-0.5 * push, rel=0.03)
    assert back[0] == pytest.approx(-0.5 * push + k * 0.004, rel=0.03)


def test_sideways_too_two_frames_tell_the_same_line(session: Session) -> None:
    """So that the rate of the simulation does not matter, and nothing shakes."""
    _, first, second = drag(session, ContactRendering(), [0.002, 0.005])
    assert force_at(first, second.at, CAP)[0] == pytest.approx(second.force[0], rel=0.03)


def test_a_place_that_is_carried_off_pulls_the_fingertip_along(session: Session) -> None:
    rendering = ContactRendering()
    (before,) = drag(session, rendering, [])
    (touch,) = session.touches()
    assert touch
    rotation, _ = touch.pose
    rendering.stuck[0] = rendering.stuck[0] + rotation.T @ np.array([0.003, 0.0, 0.0])
    (after,) = rendering.contacts(session, Workspace(), CAP, 0.0)
    assert after
    assert after.force[0] - before.force[0] == pytest.approx(2 / 3 * MATERIAL.K1 * 0.003, rel=0.03)


@pytest.mark.parametrize("fingers", [[None], []], ids=["its sensor is not trusted", "the device is gone"])
def test_a_fingertip_that_was_lifted_off_sticks_anew_where_it_comes_down(session: Session, fingers: list[None]) -> None:
    rendering = ContactRendering()
    assert np.hypot(*drag(session, rendering, [0.004])[-1].force[:2]) > 0.5
    session.set_fingers(fingers)
    session.step(0.0)
    assert rendering.contacts(session, Workspace(), CAP, 0.0) == tuple(fingers) and rendering.stuck == {}
    press(session, 0.010)
    (contact,) = rendering.contacts(session, Workspace(), CAP, 0.0)
    assert contact and np.hypot(*contact.force[:2]) < 0.02 * contact.force[2]


def test_a_larger_workspace_renders_the_same_stiffness(session: Session) -> None:
    press(session, 0.010)
    place = Workspace(origin=(0.1, 0.2, 0.3), scale=2.5, turn=TURN)
    (contact,) = contacts(session, place, CAP, 0.0)
    assert contact and contact.k_n == MATERIAL.K1
    assert contact.force[2] == pytest.approx(MATERIAL.K1 * 0.010 / 2.5, rel=0.01)
    assert place.to_session(contact.at) == pytest.approx((0.0, 0.0, TOP - 0.010), abs=1e-12)


def test_a_turned_workspace_turns_the_force(session: Session) -> None:
    rendering = ContactRendering()
    straight = drag(session, rendering, [0.004])[-1]
    (turned,) = rendering.contacts(session, Workspace(turn=TURN), CAP, 0.0)
    assert turned and straight.force[0] < -0.5
    x, y, z = straight.force
    assert turned.force == pytest.approx((y, -x, z))


def test_on_a_round_body_the_normal_is_the_way_out() -> None:
    """On an icosphere too, whose faces have their own: the nearest point decides."""
    session = Session(build_model(scenes.ball(2), [replace(MATERIAL, fill="none")]))
    way = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
    session.set_fingers([Finger(tuple(way * (scenes.BALL_RADIUS + RADIUS + 0.02)), RADIUS)])
    session.step(0.0)
    (contact,) = contacts(session, Workspace(), CAP, 0.0)
    # a chord of the second icosphere turns its faces by up to 10 degrees
    assert contact and np.dot(contact.normal, way) > np.cos(np.radians(10))


def test_no_fingertip_no_contact(session: Session) -> None:
    session.reset()
    session.set_fingers([None, Finger((0.0, 0.0, 1.0), RADIUS)])
    session.step(0.0)
    assert [contact is None for contact in contacts(session, Workspace(), CAP, 0.0)] == [True, False]
