"""A press by hand becomes ways of fingertips, and those a few keyframes."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from core.poke.stroke import Hand, Sample, Way, corners, keys
from core.session.fingertip import Finger

UP = (0.0, 0.0, 1.0)
TOP = 0.05  # [m] height of the centre where the fingertip touches
RADIUS = 0.01


def down(depth: float, x: float = 0.0, fresh_contact: bool = False) -> tuple[Finger, Any]:
    centre = (x, 0.0, TOP - depth)
    return Finger(centre, RADIUS, fresh_contact=fresh_contact), SimpleNamespace(centre=centre, depth=depth, outward=UP)


def heights(way: Way) -> list[float]:
    return [round(each.centre[2], 6) for each in way.samples]


def test_a_press_begins_and_ends_where_the_fingertip_touches_the_surface_at_rest() -> None:
    hand = Hand()
    assert hand.take(0.02, {}) is None
    assert hand.take(0.04, {0: down(0.002)}) == 0.02
    assert hand.take(0.06, {0: down(0.004)}) is None
    assert hand.take(0.08, {}) is None
    way = hand.ways[0]
    assert [each.time for each in way.samples] == [0.02, 0.04, 0.06, 0.08]
    assert heights(way) == [TOP, TOP - 0.002, TOP - 0.004, TOP] and way.outward == UP


def test_the_next_press_takes_the_place_of_the_last_and_a_second_finger_joins_it() -> None:
    hand = Hand()
    for time, held in enumerate(({0: down(0.001)}, {}, {1: down(0.001)}, {1: down(0.001), 2: down(0.002)}, {})):
        hand.take(0.02 * (time + 1), held)
    assert list(hand.ways) == [1, 2]
    assert [len(way.samples) for way in hand.ways.values()] == [4, 3]


def test_a_finger_that_comes_down_elsewhere_before_it_was_lifted_does_not_fly_there() -> None:
    hand = Hand()
    hand.take(0.02, {0: down(0.003)})
    hand.take(0.04, {0: down(0.001, x=0.04, fresh_contact=True)})
    assert [each.centre[0] for each in hand.ways[0].samples] == [0.04, 0.04]


def test_a_session_that_was_put_back_to_rest_begins_a_press_anew() -> None:
    hand = Hand()
    hand.take(0.5, {0: down(0.003)})
    assert hand.take(0.02, {0: down(0.001)}) == 0.0
    assert heights(hand.ways[0]) == [TOP, TOP - 0.001]


@pytest.mark.parametrize("fps", [24, 25, 60])
def test_keys_lead_past_the_place_at_every_frame_within_the_tolerance(fps: int) -> None:
    time = np.arange(0.0, 1.2001, 0.016)
    depth = 0.02 * np.clip(np.minimum(time / 0.25, (1.2 - time) / 0.25), 0, 1)
    x = np.where(time > 0.5, 0.01 * np.sin(8 * (time - 0.5)), 0.0)
    way = Way(UP, [Sample(t, (a, 0.0, TOP - d), RADIUS) for t, a, d in zip(time, x, depth, strict=True)])
    tolerance = 5e-5
    frames, places = keys(way, 0.0, 10.0, 1 / fps, tolerance)
    assert frames[0] == 10 and frames[-1] == 10 + np.ceil(time[-1] * fps - 1e-6)
    every = np.arange(frames[0], frames[-1] + 1)
    for axis, values in enumerate((x, 0 * x, TOP - depth)):
        wanted = np.interp((every - 10) / fps, time, values)
        assert np.abs(np.interp(every, frames, places[:, axis]) - wanted).max() <= tolerance
    assert len(frames) < 0.8 * len(every)
    assert np.ptp(places[:, 3]) == 0


def test_straight_even_motion_needs_two_keys_and_rest_none_between() -> None:
    assert corners(np.linspace((0.0, 0.0), (1.0, 2.0), 100), 1e-9) == [0, 99]
    bent = np.concatenate([np.linspace(0, 1, 11), np.ones(10), np.linspace(1, 0, 11)])[:, None]
    assert corners(bent, 1e-9) == [0, 10, 21, 31] or corners(bent, 1e-9) == [0, 10, 20, 21, 31]
    assert corners(np.zeros((1, 3)), 1e-9) == [0]


def test_a_press_amid_the_frames_of_a_playing_timeline_keeps_its_time() -> None:
    way = Way(UP, [Sample(1.0, (0.0, 0.0, TOP), RADIUS), Sample(1.5, (0.0, 0.0, TOP - 0.01), RADIUS)])
    frames, places = keys(way, 1.0, 30.5, 0.04, 1e-9)
    assert (frames[0], frames[-1]) == (30, 43)
    assert places[0, 2] == TOP and places[1, 2] == pytest.approx(TOP - 0.01 * 0.5 / 12.5)
