"""A press by hand becomes ways of fingertips, and those a few keyframes."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from core.poke.stroke import Hand, Sample, Way, keys
from core.session.fingertip import Finger

UP = (0.0, 0.0, 1.0)
TOP = 0.05  # [m] height of the centre where the fingertip touches
RADIUS = 0.01


def down(depth: float, x: float = 0.0, fresh_contact: bool = False) -> tuple[Finger, Any]:
    centre = (x, 0.0, TOP - depth)
    return Finger(centre, RADIUS, fresh_contact=fresh_contact), SimpleNamespace(centre=centre, depth=depth, outward=UP)


def heights(way: Way) -> list[float]:
    return [round(each.centre[2], 6) for each in way.samples]


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
