"""The clock of a session: the ticks of a step of time."""

from __future__ import annotations

import math

from .base import DimpleError


class Clock:
    """Time in whole ticks, whatever the steps are that it is advanced by; what is left over is carried to the next.

    tick: [s].
    time: at the end of the last step [s].
    ticks: that are over.
    begin, end: of the step under way [s].
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
            raise DimpleError("A step of time must be 0 s or longer (it is {dt}).", dt=dt)
        self.begin, self.end = self.time, self.time + dt
        self._last_tick = math.floor(self.end / self.tick + 1e-6)

    @property
    def due(self) -> int:
        """Return how many ticks of the step under way are left."""
        return max(self._last_tick - self.ticks, 0)

    def share_after(self, ticks: int) -> float:
        """Return how much of the step under way is over after some more ticks: 0 at its begin, 1 at its end."""
        return self._share((self.ticks + ticks) * self.tick)

    def stop(self, *, early: bool) -> float:
        """End the step under way, after the ticks that are over if early; return how much of it is over."""
        self.time = self.ticks * self.tick if early else self.end
        return self._share(self.time)

    def _share(self, time: float) -> float:
        return 1.0 if time >= self.end else (time - self.begin) / max(self.end - self.begin, 1e-30)
