"""Sessions: the clock, the fingertips, the pins, and what comes out."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.base import DimpleError
from core.body.model import build_model
from core.constants import MAX_STEPS
from core.material import Material, law_force
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
from tests.bodies import Shape, after, ball, soup

SOFT = Material(K1=600, K2=2000, x0=0.02, k=600, mass=0.5, damping_ratio=0.5, fill="none")
RADIUS = 0.08
BALL = ball(1, RADIUS)


def on_its_base(shape: Shape = BALL, **options: object) -> Session:
    mesh = mesh_from_triangles(*shape)
    return Session(build_model(mesh, [SOFT], pinned=base_vertices(mesh), **options))  # type: ignore[arg-type]


def above(depth: float, radius: float = 0.02, x: float = 0.0) -> Finger:
    """Return a fingertip whose lowest point is `depth` below the top of the ball."""
    return Finger((x, 0.0, RADIUS + radius - depth), radius)


def test_a_new_session_shows_the_body_at_rest() -> None:
    session = on_its_base()
    frame = session.frame
    np.testing.assert_array_equal(session.positions(), BALL[0].astype(np.float32))
    assert session.positions().dtype == np.float32 and frame.time == 0 and frame.finite and not frame.note
    assert frame.volume == pytest.approx(frame.rest_volume) and frame.pressure == 0
    assert frame.finger_forces.shape == (0, 3) and frame.depths.shape == (0,)


def test_nothing_moves_without_a_cause() -> None:
    np.testing.assert_allclose(after(on_its_base(), 0.1), BALL[0], atol=1e-8)


def test_time_runs_in_whole_ticks_and_the_rest_is_carried() -> None:
    session = on_its_base()
    assert [session.step(0.0025).steps for _ in range(4)] == [2, 3, 2, 3]
    assert session.frame.time == pytest.approx(0.010)
    assert session.step(0.0004).steps == 0 and session.step(0.0).steps == 0 and session.step(0.0006).steps == 1


@pytest.mark.parametrize("rate", [24, 29.97, 144, 1001])
def test_a_second_has_as_many_ticks_at_any_frame_rate(rate: float) -> None:
    session = Session(build_model(mesh_from_triangles(*ball(0, RADIUS)), [SOFT]), tick=0.01)
    steps = sum(session.step(1 / rate).steps for _ in range(round(rate)))
    assert steps == pytest.approx(100 * round(rate) / rate, abs=1)
    assert session.frame.time == pytest.approx(round(rate) / rate)


def test_a_budget_stops_early_and_time_lags() -> None:
    session = on_its_base()
    frame = session.step(1.0, budget=0.0)
    assert frame.steps == 1 and frame.time == pytest.approx(1e-3), "at most a tick later"
    later = session.step(0.001)
    assert later.steps == 1  # what was not done is forgotten, not owed
    assert on_its_base().step(0.05, budget=1e9).steps == 50


def test_a_fingertip_moves_linearly_and_arrives_at_the_end_of_the_step() -> None:
    whole, parts = on_its_base(), on_its_base()
    for session in (whole, parts):
        session.set_fingers([above(-0.001)])
        session.step(0.001)
    whole.set_fingers([above(0.019)])
    whole.step(0.100)
    for i in range(1, 11):
        parts.set_fingers([above(-0.001 + 0.002 * i)])
        parts.step(0.010)
    assert whole.frame.depths[0] == pytest.approx(0.019, abs=1e-6)
    np.testing.assert_allclose(parts.positions(), whole.positions(), atol=1e-9)


def test_a_fingertip_passes_each_place_of_its_way_at_its_time() -> None:
    mesh = mesh_from_triangles(*BALL)
    one, other = (Session(build_model(mesh, [SOFT], pinned=base_vertices(mesh)), backend="native64") for _ in range(2))
    places = [above(0.01, x=x).position for x in (0.0, 0.01, 0.02)]
    for session in (one, other):
        session.set_fingers([above(0.0)])
        session.step(0)
    one.set_fingers([Finger(places[-1], 0.02, via=tuple(places[:-1]))])
    one.step(0.03)
    for place in places:
        other.set_fingers([Finger(place, 0.02)])
        other.step(0.01)
    np.testing.assert_allclose(one.positions(), other.positions(), atol=1e-9)
    assert one.frame.work == pytest.approx(other.frame.work)
    frame = one.step(0.03)
    assert one.placed[0].position == pytest.approx(places[-1]) and frame.touches[0].centre == pytest.approx(places[-1])


def test_a_fingertip_that_comes_down_anew_touches_nothing_on_its_way() -> None:
    session = on_its_base()
    session.set_fingers([above(0.01)])
    session.step(0.05)
    below = Finger((0.0, 0.0, -2 * RADIUS), 0.02, fresh_contact=True)
    session.set_fingers([below])
    assert not session.step(0.001).finger_forces.any()


@pytest.mark.parametrize("first", [0.0, 0.02])
def test_a_fingertip_that_is_put_down_with_its_centre_inside_presses_like_one_that_came_in(first: float) -> None:
    mesh = mesh_from_triangles(*ball(3, RADIUS))
    put, led = (Session(build_model(mesh, [SOFT], pinned=base_vertices(mesh)), backend="native64") for _ in range(2))
    led.set_fingers([above(0.0, radius=0.01)])
    led.step(0)
    for session, seconds in ((led, 0.2), (put, first)):
        session.set_fingers([above(0.015, radius=0.01)])
        session.step(seconds)
        session.step(0.3)
    forces = [float(session.step(0.1).finger_forces[0, 2]) for session in (led, put)]
    assert forces[0] > 0 and forces[1] == pytest.approx(forces[0], rel=0.05)
    assert put.frame.depths[0] == pytest.approx(0.015, abs=1e-4)


def test_a_fingertip_in_a_hurry_is_slowed_down_and_catches_up() -> None:
    session = on_its_base()
    session.set_fingers([Finger((0, 0, 1.0), 0.02)])
    session.step(0.001)
    session.set_fingers([above(0.01)])
    session.step(0.001)
    assert session.frame.depths[0] == 0  # it may go a quarter of its radius in a tick
    session.step(0.3)
    assert session.frame.depths[0] == pytest.approx(0.01)


def test_three_fingertips_each_have_their_depth_and_law() -> None:
    session = on_its_base()
    start = [above(0.0, x=0.0), Finger((RADIUS + 0.01, 0, 0), 0.01), Finger((0.0, RADIUS + 0.5, 0), 0.01)]
    session.set_fingers(start)
    session.step(0.001)
    session.set_fingers([above(0.01), Finger((RADIUS + 0.005, 0, 0), 0.01), start[2]])
    session.step(0.1)
    session.step(0.2)
    frame = session.step(0.1)
    assert frame.depths == pytest.approx([0.01, 0.005, 0.0], abs=1.5e-3)
    laws = [law_force(touch.depth, *touch.law) for touch in frame.touches if touch]
    assert frame.pushes == pytest.approx(laws, rel=1e-6) and laws[0] > laws[1] > 0
    assert not frame.finger_forces[2].any()


def test_a_lifted_finger_feels_nothing_and_a_new_one_starts_where_it_is_put() -> None:
    session = on_its_base()
    session.set_fingers([above(0.0), None])
    session.step(0.001)
    session.set_fingers([above(0.01), None])
    assert session.step(0.05).finger_forces[0, 2] > 0
    session.set_fingers([None, above(0.01)])
    frame = session.step(0.001)
    assert not frame.finger_forces[0].any() and frame.depths[0] == 0
    assert frame.depths[1] < 0.001, "it is put down in the dent"
    frame = session.step(2.0)
    assert frame.depths[1] == pytest.approx(0.01, rel=1e-3) and frame.finger_forces[1, 2] > 0
    session.set_fingers([])
    frame = session.step(0.001)
    assert frame.finger_forces.shape == (0, 3) and frame.pushes.shape == (0,)


@pytest.mark.parametrize(
    ("fingers", "words"),
    [
        ([above(0)] * 4, "at most 3"),
        ([Finger((0, 0, 0), 0.0)], "radius greater than 0"),
        ([Finger((0, 0, 0), -1.0)], "radius greater than 0"),
        ([Finger((0, 0, 0), np.nan)], "radius greater than 0"),
        ([Finger((0, 0, 0), np.inf)], "location with finite"),
        ([Finger((0, np.nan, 0), 0.01)], "location with finite"),
        ([None, Finger((0, 0), 0.01)], "location with finite"),  # type: ignore[arg-type]
    ],
)
def test_a_fingertip_that_cannot_be_is_refused_and_the_others_stay(fingers: list[Finger | None], words: str) -> None:
    session = on_its_base()
    session.set_fingers([above(0.005)])
    with pytest.raises(DimpleError, match=words):
        session.set_fingers(fingers)
    assert session.step(0.02).depths == pytest.approx([0.005], abs=1e-6)


@pytest.mark.parametrize("dt", [-0.001, np.nan, np.inf])
def test_time_that_is_no_time_is_refused(dt: float) -> None:
    with pytest.raises(DimpleError, match="0 s or longer"):
        on_its_base().step(dt)
    with pytest.raises(DimpleError, match="longer than 0 s"):
        Session(on_its_base().model, tick=min(dt, 0.0))


def test_pins_arrive_although_a_frame_ends_between_two_ticks() -> None:
    """At 24 frames a second the last tick of a frame ends before it: the rest of the way is gone in the next."""
    session, shift = on_its_base(), np.array([0.03, -0.01, 0.02])
    session.set_pins(BALL[0] + shift)
    for _ in range(48):
        session.step(1 / 24)
    pinned = session.model.pinned
    np.testing.assert_array_equal(session.positions()[pinned], (BALL[0] + shift).astype(np.float32)[pinned])
    np.testing.assert_allclose(session.positions(), BALL[0] + shift, atol=1e-6)


def test_a_body_carried_by_its_pins_neither_leads_nor_lags() -> None:
    """Springs and damping are against the shape at rest as it moves; vertices differ by less than a substep's way."""
    session, speed, way = on_its_base(), 0.3, 0.0
    for _ in range(30):
        way += speed * 0.04
        session.set_pins(BALL[0] + (way, 0, 0))
        session.step(0.04)
    error = session.positions()[:, 0] - BALL[0][:, 0] - way
    assert np.abs(error).max() < speed * session.clock.tick / session.substeps
    assert abs(error.mean()) < 0.02 * speed * session.clock.tick / session.substeps


def test_turned_pins_turn_the_body() -> None:
    session = on_its_base()
    angle = 0.5
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    for i in range(1, 11):
        a = angle * i / 10
        part = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        session.set_pins(BALL[0] @ part.T)
        session.step(0.05)
    np.testing.assert_allclose(after(session, 1.5), BALL[0] @ turn.T, atol=1e-4)


@pytest.mark.parametrize("wrong", [np.zeros((3, 3)), np.zeros(3), np.full((42, 3), np.nan)])
def test_pins_sent_nowhere_are_refused(wrong: np.ndarray) -> None:
    with pytest.raises(DimpleError, match="vert"):
        on_its_base().set_pins(wrong)


def test_the_work_of_a_fingertip_is_its_force_along_its_way_and_little_of_it_comes_back() -> None:
    session = on_its_base()
    session.set_fingers([above(0.0)])
    session.step(0.0)
    depths, impulses = np.linspace(0, 0.02, 201), [0.0]
    for depth in depths[1:]:
        session.set_fingers([above(depth)])
        impulses.append(session.step(0.01).touches[0].impulse[2])
    pressed = session.frame.work
    assert pressed == pytest.approx(sum(impulses) / 0.01 * (depths[1] - depths[0]), rel=1e-6) and pressed > 0
    for depth in depths[::-1]:
        session.set_fingers([above(depth)])
        session.step(0.01)
    assert 0 < session.frame.work < 0.5 * pressed, "some is lost to damping and friction, and none is made"
    session.reset()
    assert session.frame.work == 0


def test_reset_puts_everything_back() -> None:
    session = on_its_base()
    session.set_fingers([above(0.02)])
    session.set_pins(BALL[0] + 0.01)
    session.step(0.1)
    session.reset()
    np.testing.assert_array_equal(session.positions(), BALL[0].astype(np.float32))
    assert session.frame.time == 0 and session.frame.depths.shape == (0,)
    np.testing.assert_allclose(after(session, 0.05), BALL[0], atol=1e-8)


def test_a_body_that_was_put_back_has_no_pressure_of_the_press_before() -> None:
    mesh = mesh_from_triangles(*BALL)
    session = Session(build_model(mesh, [replace(SOFT, fill="liquid")], pinned=base_vertices(mesh)))
    session.set_fingers([above(0.02)])
    assert session.step(0.1).pressure > 100
    session.reset()
    frame = session.step(0.0)
    assert frame.pressure == 0 and frame.volume == pytest.approx(frame.rest_volume)


def test_a_fingertip_keeps_the_side_by_which_it_came_in_between_two_ticks() -> None:
    """It is put down on a thin lens and pressed beyond its middle within the first millisecond."""
    points, faces = ball(3, RADIUS)
    mesh = mesh_from_triangles(points * (1, 1, 0.05), faces)
    session = Session(build_model(mesh, [SOFT], pinned=np.ones(len(points), bool)))
    thick, radius = 0.05 * RADIUS, 0.02
    session.set_fingers([Finger((0, 0, 1.02 * thick), radius)])
    assert session.step(0.0).depths == pytest.approx([radius - 0.02 * thick], abs=1e-6)
    session.set_fingers([Finger((0, 0, -0.2 * thick), radius)])
    assert session.step(0.001).depths == pytest.approx([radius + 1.2 * thick], abs=1e-6)


def test_a_long_step_of_a_stiff_body_takes_more_than_one_call() -> None:
    mesh = mesh_from_triangles(*ball(0, RADIUS))
    session = Session(build_model(mesh, [replace(SOFT, k=2e9)]))
    seconds = 1.1 * MAX_STEPS / session.substeps * session.clock.tick
    assert session.step(seconds).steps == math.floor(seconds / session.clock.tick)


def test_what_blows_up_is_put_back_with_a_note_and_goes_on() -> None:
    for free in (True, False):
        mesh = mesh_from_triangles(*BALL)
        session = Session(build_model(mesh, [SOFT], pinned=None if free else base_vertices(mesh)))
        fling = np.where(np.arange(42) == 40, 1e30, 0.0) * np.ones((3, 1))
        session.body.set_state(mesh.rest_positions.T, fling)
        frame = session.step(0.02)
        assert not frame.finite and "was reset" in frame.note
        np.testing.assert_array_equal(session.positions(), BALL[0].astype(np.float32))
        assert session.step(0.02).finite


def test_every_input_vertex_moves_with_the_one_it_lies_on() -> None:
    torn, whole = on_its_base(soup(BALL)), on_its_base()
    for session in (torn, whole):
        session.set_fingers([above(0.0)])
        session.step(0.001)
        session.set_fingers([above(0.015)])
        session.step(0.05)
    assert torn.positions().shape == (240, 3)
    np.testing.assert_allclose(torn.positions(), whole.positions()[BALL[1].ravel()], atol=1e-6)


def test_loose_vertices_stay_and_do_not_hold_the_body() -> None:
    points, faces = BALL
    far = np.array([[100.0, 0, 0], [0, 0.3, 0]])
    lone = Session(
        build_model(mesh_from_triangles(np.concatenate([points, far]), faces), [SOFT], gravity=(0, 0, -9.81))
    )
    plain = Session(build_model(mesh_from_triangles(points, faces), [SOFT], gravity=(0, 0, -9.81)))
    frame = lone.step(0.1)
    assert frame.finite
    np.testing.assert_array_equal(lone.positions()[42:], far.astype(np.float32))
    np.testing.assert_allclose(lone.positions()[:42], after(plain, 0.1), atol=1e-6)
