"""Several sessions that do not meet: one native call steps all of them, on every core, to the bits of each alone."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Protocol

from . import native
from .frame import Frame
from .solver import motion
from .solver.motion import Motion

TICKS_AT_ONCE = 8  # at most between looks at the clock, where there is a budget


class Stepped(Protocol):
    """What is asked of a session; `session.Session` says more."""

    body: native.Body
    most: int

    def begin(self, dt: float) -> None: ...
    @property
    def due(self) -> int: ...
    def next_motion(self, ticks: int) -> Motion: ...
    def take(self, result: motion.Frame) -> bool: ...
    def finish(self, *, early: bool = False) -> Frame: ...


def ticks_that_fit(done: int, spent: float, budget: float | None) -> int:
    """Return how many ticks to run before the next look at the clock: what is left pays for them, or one.

    Args:
        done: ticks so far, in so much wall time spent [s].
        budget: wall time for all [s], None without a limit.
    """
    if budget is None:
        return motion.MAX_STEPS
    return max(1, min(TICKS_AT_ONCE, int(done * (budget - spent) / max(spent, 1e-9))))


def is_spent(done: int, spent: float, budget: float | None) -> bool:
    """Tell whether one more tick would take longer than the budget; the arguments are those of `ticks_that_fit`."""
    return budget is not None and spent * (done + 1) > budget * done


def step_all(
    sessions: Sequence[Stepped], seconds: Sequence[float], *, budget: float | None = None
) -> list[Frame]:
    """Advance each session by its time [s] in whole ticks; what is left over is carried to the next call.

    Args:
        budget: wall time [s] that only a first tick of each may exceed; the simulated time of those that are not done
            then lags behind.

    Raises:
        DimpleError: a time is negative or not a number.
    """
    started = time.perf_counter()
    for session, dt in zip(sessions, seconds, strict=True):
        session.begin(dt)
    going = [each for each in sessions if each.due]
    done, spent = 0, 0.0
    while going:
        at_once = ticks_that_fit(done, spent, budget)
        motions = [session.next_motion(min(session.due, session.most, at_once)) for session in going]
        results = native.step_many([session.body for session in going], motions)
        going = [each for each, result in zip(going, results, strict=True) if each.take(result) and each.due]
        done, spent = done + max(each.ticks for each in motions), time.perf_counter() - started
        if is_spent(done, spent, budget):
            break
    return [session.finish(early=session in going) for session in sessions]
