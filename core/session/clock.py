"""The clock of a session."""

from __future__ import annotations

import math

from ..base import DimpleError


class Clock:
    """Time in whole ticks, whatever the duration of the steps; the remainder of a step is carried over to the next.

    tick: duration [s].
    time: time at the end of the last step [s].
    ticks: number of ticks done.
    begin, end: of the current step [s].
    """

    def __init__(self, tick: float) -> None:
        if not tick > 0:
            raise DimpleError("A tick must be longer than 0 s (it is {tick}).", tick=tick)
        self.tick = tick
        self.reset()

    def reset(self) -> None:
        """Go back to zero."""
        self.time, self.ticks, self.begin, self.end = 0.0, 0, 0.0, 0.0
        self._last_tick = 0

    def start(self, dt: float) -> None:
        """Begin a step of dt [s].

        Raises:
            DimpleError: dt is negative or not a number.
        """
        if not 0 <= dt < math.inf:
            raise DimpleError("A time step must be 0 s or longer (it is {dt}).", dt=dt)
        self.begin, self.end = self.time, self.time + dt
        self._last_tick = math.floor(self.end / self.tick + 1e-6)

    @property
    def due(self) -> int:
        """Return the number of ticks left in the current step."""
        return max(self._last_tick - self.ticks, 0)

    def share_after(self, ticks: int) -> float:
        """Return the share of the current step that is over after some more ticks: 0 at its start, 1 at its end."""
        return self._share((self.ticks + ticks) * self.tick)

    def share_of_remainder(self, ticks: int) -> float:
        """Return the share of the rest of the current step that some more ticks take."""
        share = self.share_after(ticks)
        return 1.0 if share >= 1 else 1 - (1 - share) / (1 - max(self.share_after(0), 0.0))

    def stop(self, *, early: bool) -> float:
        """End the current step, if early after the ticks done; return the share of it that is over."""
        self.time = self.ticks * self.tick if early else self.end
        return self._share(self.time)

    def _share(self, time: float) -> float:
        return 1.0 if time >= self.end else (time - self.begin) / max(self.end - self.begin, 1e-30)
