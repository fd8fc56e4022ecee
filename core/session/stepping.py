"""The loop that steps sessions tick by tick within a budget of wall time."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from ..constants import MAX_STEPS
from ..native import Body, motion, step_many
from .frame import Frame


class Stepped(Protocol):
    """What the loop needs of a session, see `session.Session`, which itself needs the loop."""

    body: Body
    most: int

    @property
    def rides(self) -> bool: ...
    def begin(self, dt: float, *, alone: bool = True) -> None: ...
    @property
    def due(self) -> int: ...
    def next_motion(self, ticks: int) -> motion.Motion: ...
    def take(self, result: motion.Frame) -> bool: ...
    def finish(self, *, early: bool = False) -> Frame: ...


_Session = TypeVar("_Session", bound=Stepped)
Results = tuple[Sequence[motion.Frame], int]  # of some sessions, and the ticks that were run


def step_all(
    sessions: Sequence[_Session],
    seconds: Sequence[float],
    *,
    budget: float | None = None,
    together: Callable[[Sequence[_Session], int], Results] | None = None,
) -> list[Frame]:
    """Advance each session by its time [s] in whole ticks; the remainder is carried over to the next call.

    Args:
        budget: wall time [s] that only the first tick of each may exceed; the simulated time of those that are not done
            then lags behind.
        together: runs sessions that touch each other for at most a number of ticks; returns the result of each, and the
            number of ticks. When one session ends, all do.

    Raises:
        DimpleError: a time is negative or not a number.
    """
    started = time.perf_counter()
    for session, dt in zip(sessions, seconds, strict=True):
        session.begin(dt, alone=together is None)
    going, done, spent = [each for each in sessions if each.due], 0, 0.0
    while going and not (together and len(going) < len(sessions)):
        results, ticks = (together or _side_by_side)(going, _ticks_that_fit(done, spent, budget))
        going = [each for each, result in zip(going, results, strict=True) if each.take(result) and each.due]
        done, spent = done + ticks, time.perf_counter() - started
        if budget is not None and spent * (done + 1) > budget * done:  # one more tick would exceed it
            break
    else:
        going = []
    return [session.finish(early=session in going) for session in sessions]


def _side_by_side(sessions: Sequence[Stepped], at_once: int) -> Results:
    """Run sessions that do not touch, in one native call on all cores: bit for bit as each alone."""
    motions = [session.next_motion(min(session.due, session.most, at_once)) for session in sessions]
    moving = [(session.body, each) for session, each in zip(sessions, motions, strict=True) if not session.rides]
    found = iter(step_many(*map(list, zip(*moving, strict=True))) if moving else ())
    results = [
        motion.Frame((None,) * len(each.fingertips), session.body.model.mesh.volume, 0.0, each.ticks, True, False)
        if session.rides else next(found)
        for session, each in zip(sessions, motions, strict=True)
    ]  # fmt: skip
    return results, max(each.ticks for each in motions)


def _ticks_that_fit(done: int, spent: float, budget: float | None) -> int:
    """Return the number of ticks to run before the next look at the clock: those that the budget still allows, at least
    one. They are no more than were run so far, since the next ones may touch something and cost more.

    Args:
        done: ticks so far, which took `spent` [s] of wall time.
    """
    if budget is None:
        return MAX_STEPS
    return max(1, min(done, int(done * (budget - spent) / max(spent, 1e-9))))
