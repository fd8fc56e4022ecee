"""Several sessions that do not meet: one native call steps all of them, on every core, to the bits of each alone."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Protocol

from .frame import Frame
from .solver import motion
from .solver.backend import Body, step_bodies
from .solver.motion import Motion

TICKS_AT_ONCE = 8  # between looks at the clock, where there is a budget


class Stepped(Protocol):
    """What is asked of a session; `session.Session` says more."""

    body: Body
    most: int

    def begin(self, dt: float) -> None: ...
    @property
    def due(self) -> int: ...
    def next_motion(self, ticks: int) -> Motion: ...
    def take(self, result: motion.Frame) -> bool: ...
    def finish(self, *, early: bool = False) -> Frame: ...


def step_all(
    sessions: Sequence[Stepped], seconds: Sequence[float], *, budget: float | None = None
) -> list[Frame]:
    """Advance each session by its time [s] in whole ticks; what is left over is carried to the next call.

    Args:
        budget: stop after this much wall time [s]; the simulated time of those that are not done then lags behind.

    Raises:
        DimpleError: a time is negative or not a number.
    """
    started = time.perf_counter()
    for session, dt in zip(sessions, seconds, strict=True):
        session.begin(dt)
    # the largest first, so that no core is left alone with it at the end
    going = sorted((each for each in sessions if each.due), key=lambda each: -len(each.body.model.mass))
    at_once = TICKS_AT_ONCE if budget is not None else motion.MAX_STEPS
    while going:
        motions = [session.next_motion(min(session.due, session.most, at_once)) for session in going]
        results = step_bodies([session.body for session in going], motions)
        going = [each for each, result in zip(going, results, strict=True) if each.take(result) and each.due]
        if budget is not None and time.perf_counter() - started > budget:
            break
    return [session.finish(early=session in going) for session in sessions]
