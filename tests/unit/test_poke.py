"""The poke's state machine: what the pointer says becomes where the fingertips are."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.poke import Hit, Kind, PokeEvent, PokeState, fingers, lifted, on_event, with_settings
from core.session import Finger

TOP = Hit(point=(0.0, 0.0, 0.1), normal=(0.0, 0.0, 1.0), body=7)
SIDE = Hit(point=(0.1, 0.0, 0.0), normal=(1.0, 0.0, 0.0), body=7)
START = PokeState(radius=0.01, depth=0.02)


def run(state: PokeState, *events: PokeEvent) -> PokeState:
    """Return the state after some events."""
    for event in events:
        state = on_event(state, event)
    return state


def press(hit: Hit | None = TOP, pressure: float = 1.0) -> PokeEvent:
    return PokeEvent(kind=Kind.PRESS, hit=hit, pressure=pressure)


def ticks(seconds: float, dt: float = 0.001) -> list[PokeEvent]:
    return [PokeEvent(kind=Kind.TICK, amount=dt)] * round(seconds / dt)


def finger(number: int) -> PokeEvent:
    return PokeEvent(kind=Kind.FINGER, amount=number)


RELEASE = PokeEvent(kind=Kind.RELEASE)


def test_a_fingertip_starts_where_its_sphere_touches_the_surface() -> None:
    state = run(START, press())
    assert fingers(state, 7) == (Finger((0.0, 0.0, pytest.approx(0.11)), 0.01), None, None)


def test_a_held_press_goes_in_at_a_steady_rate_and_stays_at_its_depth() -> None:
    half = run(START, press(), *ticks(0.125))
    deep = run(half, *ticks(0.5))
    assert fingers(half, 7)[0].position[2] == pytest.approx(0.10)
    assert fingers(deep, 7)[0].position[2] == pytest.approx(0.09)


def test_the_press_is_the_same_however_time_is_cut_up() -> None:
    fine = run(START, press(), *ticks(0.2, 0.001))
    coarse = run(START, press(), *ticks(0.2, 0.04))
    assert fine.tips[0].reached == pytest.approx(coarse.tips[0].reached)


def test_a_press_goes_straight_in_or_along_the_view() -> None:
    slanted = (0.0, math.sin(0.5), -math.cos(0.5))
    event = PokeEvent(kind=Kind.PRESS, hit=TOP, view=slanted)
    along_normal = run(START, event, *ticks(1.0))
    along_view = run(replace(START, along_normal=False), event, *ticks(1.0))
    assert fingers(along_view, 7)[0].position[1] == pytest.approx(0.02 * math.sin(0.5))
    assert fingers(along_normal, 7)[0].position == (0.0, 0.0, pytest.approx(0.09))


def test_a_press_beside_every_body_does_nothing() -> None:
    assert run(START, press(None), RELEASE) == START


def test_release_takes_the_fingertip_out() -> None:
    state = run(START, press(), *ticks(0.3), RELEASE)
    assert not state.pressing
    state = run(state, *ticks(0.2))
    assert fingers(state, 7)[0].position[2] > 0.09
    assert fingers(run(state, *ticks(0.1), RELEASE), 7) == (None, None, None)


def test_a_short_press_comes_out_in_the_same_time_as_a_long_one() -> None:
    state = run(START, press(), *ticks(0.05), RELEASE, *ticks(0.2))
    assert state.tips[0] is not None
    assert run(state, *ticks(0.06)).tips[0] is None


def test_a_drag_slides_the_fingertip_over_the_surface_without_a_jump() -> None:
    state = run(START, press(), *ticks(0.3), PokeEvent(kind=Kind.MOVE, hit=SIDE, view=(-1.0, 0.0, 0.0)))
    before = np.array(fingers(state, 7)[0].position)
    after = np.array(fingers(run(state, *ticks(0.001)), 7)[0].position)
    assert np.linalg.norm(after - before) < 0.005
    settled = fingers(run(state, *ticks(1.0)), 7)[0].position
    assert settled == pytest.approx((0.09, 0.0, 0.0), abs=1e-6)


def on_ball(angle: float) -> Hit:
    """Return what the pointer is on, of a ball of 80 mm, at an angle from its top."""
    out = math.sin(angle), 0.0, math.cos(angle)
    return Hit(point=tuple(0.08 * c for c in out), normal=out, body=7)


@pytest.mark.parametrize("dt", [0.016, 0.1])
def test_however_fast_a_drag_is_the_fingertip_goes_round_the_body_and_not_through_it(dt: float) -> None:
    state = run(replace(START, depth=0.007), press(on_ball(-0.7)), *ticks(0.3))
    places, moves = [], round(dt / 0.004)
    for begin in np.arange(-0.7, 0.7, dt / 0.08):  # 1 m/s
        way = [PokeEvent(kind=Kind.MOVE, hit=on_ball(begin + 0.05 * j)) for j in range(1, moves + 1)]
        state = run(state, *way, PokeEvent(kind=Kind.TICK, amount=dt))
        tip = fingers(state, 7)[0]
        places += [*tip.via, tip.position]
    away = np.linalg.norm(places, axis=1)
    assert np.ptp(np.array(places)[:, 0]) > 0.07
    assert away == pytest.approx(0.08 + 0.01 - 0.007, abs=2e-4)
    legs = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert legs.max() < 0.01, "no leg of its way is longer than its radius"


def test_where_the_pointer_leaps_to_a_part_behind_the_fingertip_is_lifted_and_comes_down_there() -> None:
    pressed = run(START, press(), *ticks(0.3))
    behind = PokeEvent(kind=Kind.MOVE, hit=replace(TOP, point=(0.002, 0.0, 0.05)))
    state = run(pressed, behind, *ticks(0.01, 0.01))
    tip = fingers(state, 7)[0]
    assert tip.fresh_contact and tip.position == pytest.approx((0.002, 0.0, 0.06 - 0.02 * 0.01 / 0.25))
    assert not fingers(run(state, *ticks(0.01, 0.01)), 7)[0].fresh_contact
    slope = PokeEvent(kind=Kind.MOVE, hit=replace(TOP, point=(0.04, 0.0, 0.05)))
    assert run(pressed, slope, *ticks(0.01, 0.01)).tips[0].reached > 0.01


def test_a_drag_off_the_body_or_onto_another_leaves_the_fingertip_where_it_is() -> None:
    pressed = run(START, press(), *ticks(0.3))
    for hit in (None, replace(SIDE, body=8)):
        state = run(pressed, PokeEvent(kind=Kind.MOVE, hit=hit), *ticks(0.5))
        assert fingers(state, 7) == fingers(pressed, 7)


def test_pen_pressure_is_depth() -> None:
    state = run(START, press(pressure=0.5), *ticks(1.0))
    assert state.tips[0].reached == pytest.approx(0.01)
    state = run(state, PokeEvent(kind=Kind.MOVE, hit=TOP, pressure=0.1), *ticks(1.0))
    assert state.tips[0].reached == pytest.approx(0.002)


def test_by_force_the_fingertip_stays_where_it_touches_and_its_force_grows_and_fades() -> None:
    state = run(replace(START, by_force=True), press(), *ticks(0.125))
    half = fingers(state, 7)[0]
    assert half.force == pytest.approx(START.force / 2) and half.inward == (0.0, 0.0, -1.0)
    assert half.position == pytest.approx((0.0, 0.0, 0.11))
    state = run(state, *ticks(0.2))
    assert fingers(state, 7)[0].force == pytest.approx(START.force)
    state = run(state, RELEASE, *ticks(0.125))
    assert fingers(state, 7)[0].force == pytest.approx(START.force / 2)
    state = run(with_settings(state, by_force=False), *ticks(0.2), press(), *ticks(0.3))
    assert fingers(state, 7)[0].force is None, "by depth again"


def test_a_force_pushes_straight_into_the_surface_however_one_looks_at_it() -> None:
    slanted = PokeEvent(kind=Kind.PRESS, hit=TOP, view=(0.0, math.sin(1.2), -math.cos(1.2)))
    state = run(replace(START, by_force=True), slanted, *ticks(1.0))
    assert fingers(state, 7)[0].inward == pytest.approx((0.0, 0.0, -1.0))
    moved = PokeEvent(kind=Kind.MOVE, hit=SIDE, view=(-0.6, 0.0, -0.8))
    state = run(state, moved, *ticks(1.0))
    assert fingers(state, 7)[0].inward == pytest.approx((-1.0, 0.0, 0.0), abs=1e-6)


def test_settings_that_were_changed_in_a_panel_reach_a_press_under_way() -> None:
    state = run(START, press(), *ticks(1.0))
    state = run(with_settings(state, radius=0.02, depth=0.01), *ticks(1.0))
    assert state.tips[0].radius == 0.02 and state.tips[0].reached == pytest.approx(0.01)


def test_a_body_of_another_size_is_let_go_of() -> None:
    state = run(START, press(), *ticks(0.3))
    assert lifted(state, 8) == state
    assert lifted(state, 7).tips == (None, None, None) and not lifted(state, 7).pressing


def test_choosing_another_finger_leaves_the_first_pressed_so_that_a_pinch_can_be_set_up() -> None:
    state = run(START, press(), *ticks(0.3), finger(2), RELEASE, *ticks(0.5))
    state = run(state, press(SIDE), *ticks(0.3), RELEASE, *ticks(0.5))
    assert [tip is not None for tip in state.tips] == [True, False, False]
    state = run(state, finger(1), finger(1), *ticks(0.5))
    assert state.tips == (None, None, None)


def test_a_finger_that_does_not_exist_is_not_chosen() -> None:
    assert run(START, finger(4), finger(0)) == START


def test_no_time_at_all_for_a_press_means_at_once() -> None:
    state = replace(START, press_s=0.0, release_s=0.0)
    state = run(state, press(), *ticks(0.001))
    assert state.tips[0].reached == pytest.approx(0.02)
    assert run(state, RELEASE, *ticks(0.001)).tips[0] is None


def test_any_events_in_any_order_keep_the_fingertips_finite() -> None:
    random = np.random.default_rng(1)
    state, kinds = START, list(Kind)
    for _ in range(5000):
        hit = TOP if random.random() < 0.5 else SIDE if random.random() < 0.7 else None
        kind = kinds[random.integers(len(kinds))]
        amount = random.random() * 0.1 if kind is Kind.TICK else float(random.integers(-2, 4))
        state = on_event(state, PokeEvent(kind=kind, hit=hit, pressure=random.random(), amount=amount))
        for tip in state.tips:
            if tip:
                assert np.isfinite(tip.finger.position).all()
                assert 0 <= tip.reached
                assert math.hypot(*tip.aim.inward) == pytest.approx(1)


LEFT = Hit(point=(-0.08, 0.0, 0.06), normal=(-0.8, 0.0, 0.6), body=7)
RIGHT = Hit(point=(0.08, 0.0, 0.06), normal=(0.8, 0.0, 0.6), body=7)
PINCH = [press(LEFT), *ticks(0.3), finger(2), press(RIGHT), *ticks(1.0)]


def test_two_fingertips_on_opposite_sides_pinch_towards_each_other() -> None:
    state = run(START, *PINCH)
    left, right = fingers(state, 7)[:2]
    for one, hit, way in ((left, LEFT, 1.0), (right, RIGHT, -1.0)):
        touching = np.array(hit.point) + START.radius * np.array(hit.normal)
        assert one.position == pytest.approx(touching + START.depth * np.array([way, 0, 0]), abs=1e-5)


def test_the_first_fingertip_of_a_pinch_turns_without_a_jump() -> None:
    state = run(START, *PINCH[:-1000])
    before = np.array(fingers(state, 7)[0].position)
    for _ in range(100):
        state = run(state, *ticks(0.001))
        after = np.array(fingers(state, 7)[0].position)
        assert np.linalg.norm(after - before) < 0.05 * START.depth
        before = after


def test_two_fingertips_on_one_side_or_on_two_bodies_press_as_they_are_told() -> None:
    near = Hit(point=(-0.02, 0.0, 0.1), normal=(0.0, 0.0, 1.0), body=7)
    for second in (near, replace(RIGHT, body=8)):
        state = run(START, press(LEFT), *ticks(0.3), finger(2), press(second), *ticks(0.5))
        for tip, hit in zip(state.tips, (LEFT, second), strict=False):
            assert tip.aim.inward == pytest.approx(tuple(-c for c in hit.normal))
