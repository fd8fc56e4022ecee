"""Several sessions in one call: the bits of each alone, and one budget for all."""

from collections.abc import Sequence

import numpy as np
import pytest

from core import native
from core.native import Body
from core.native.motion import Frame as MotionFrame
from core.native.motion import Motion
from core.session import Finger, Session, step_all
from studies import scenes

TOP = scenes.BALL_RADIUS + scenes.FINGERTIP
SECONDS = [0.05, 0.02, 0.0, 0.0335]


def pressed() -> list[Session]:
    """Return balls: one pressed, one pushed by a force, one left alone, and a larger one."""
    found = [Session(scenes.poke_ball(2).model) for _ in SECONDS[:-1]]
    found.append(Session(scenes.poke_ball(3).model))
    for session, force in zip(found, (None, 1.0, None, None), strict=True):
        session.set_fingers([Finger((0.0, 0.0, TOP), scenes.FINGERTIP)])
        session.step(0.0)
        session.set_fingers([Finger((0.0, 0.0, TOP - 2e-3), scenes.FINGERTIP, force)])
    return found


def test_sessions_stepped_together_move_to_the_bits_of_each_alone() -> None:
    alone, together = pressed(), pressed()
    expected = [session.step(dt) for session, dt in zip(alone, SECONDS, strict=True)]
    for frame, wanted, a, b in zip(step_all(together, SECONDS), expected, together, alone, strict=True):
        assert (frame.time, frame.touches) == (wanted.time, wanted.touches)
        assert np.array_equal(a.positions(), b.positions())


def test_a_budget_is_that_of_all_and_none_runs_far_ahead() -> None:
    frames = step_all(pressed(), [1.0, 0.0, 1.0, 1.0], budget=0.0)
    assert [frame.steps for frame in frames] == [1, 0, 1, 1]
    assert step_all([], []) == []


@pytest.mark.parametrize(("cost", "ticks"), [(0.060, 1), (0.012, 2), (0.0101, 2), (0.00101, 24)])
def test_a_budget_is_exceeded_by_a_first_tick_only(cost: float, ticks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tick of all takes so long [s], by a clock of its own, and there are 25 ms."""
    now, step_many = 0.0, native.step_many

    def step(bodies: Sequence[Body], motions: Sequence[Motion]) -> list[MotionFrame]:
        nonlocal now
        now += cost * max(each.ticks for each in motions)
        return step_many(bodies, motions)

    monkeypatch.setattr("core.session.stepping.step_many", step)
    monkeypatch.setattr("time.perf_counter", lambda: now)
    frames = step_all(pressed()[:3:2], [1.0, 1.0], budget=0.025)
    assert [frame.steps for frame in frames] == [ticks, ticks]
