"""The clock of a session: the ticks of a step of time, each simulated at once, or in parts where that is faster."""

from __future__ import annotations

import math

from .base import DimpleError
from .reduction.slow_press import SETTLING


class Clock:
    """Time in whole ticks, whatever the steps are that it is advanced by; what is left over is carried to the next.

    tick: of the fingertips' time [s].
    faster: times that the body is simulated as fast as slow fingertips go.
    part: of a tick, which is simulated at a time [s].
    parts: of a tick that are simulated: all of them, or one while fingertips are slow.
    time: at the end of the last step [s].
    ticks: that are over.
    begin, end: of the step under way [s].
    """

    def __init__(self, tick: float) -> None:
        if not tick > 0:
            raise DimpleError(f"A tick must be longer than 0 s (it is {tick}).")
        self.tick, self.faster, self.part = tick, 1, tick
        self.reset()

    def set(self, tick: float, faster: int) -> bool:
        """Go by other ticks from now on; tell whether they are others."""
        if (tick, faster) == (self.tick, self.faster):
            return False
        self.tick, self.faster, self.part = tick, faster, tick / faster
        self.ticks = round(self.time / tick)
        return True

    def reset(self) -> None:
        """Go back to zero."""
        self.time, self.ticks, self.begin, self.end = 0.0, 0, 0.0, 0.0
        self._last_tick = 0
        self._settles_at = 0.0  # until then [s] more moves the body than slow fingertips
        self.parts = self.faster

    def start(self, dt: float) -> None:
        """Begin a step of dt [s].

        Raises:
            DimpleError: dt is negative or not a number.
        """
        if not 0 <= dt < math.inf:
            raise DimpleError(f"A step of time must be 0 s or longer (it is {dt}).")
        self.begin, self.end = self.time, self.time + dt
        self._last_tick = math.floor(self.end / self.tick + 1e-6)

    def unsettle(self) -> None:
        """Simulate all parts of the ticks until a while after the step under way."""
        self._settles_at = self.end + SETTLING

    def pace(self) -> None:
        """Say how many parts of the ticks of the step under way are simulated."""
        self.parts = self.faster if self.begin < self._settles_at else 1

    @property
    def due(self) -> int:
        """Return how many ticks of the step under way are left."""
        return max(self._last_tick - self.ticks, 0)

    def share_after(self, ticks: float) -> float:
        """Return how much of the step under way is over after some more ticks: 0 at its begin, 1 at its end."""
        return self._share((self.ticks + ticks) * self.tick)

    def stop(self, *, early: bool) -> float:
        """End the step under way, after the ticks that are over if early; return how much of it is over."""
        self.time = self.ticks * self.tick if early else self.end
        return self._share(self.time)

    def _share(self, time: float) -> float:
        return 1.0 if time >= self.end else (time - self.begin) / max(self.end - self.begin, 1e-30)
