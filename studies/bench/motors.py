"""The last limits before a motor: magnitude of the force, its slew rate, and the heat of ten seconds."""

from __future__ import annotations

import math
from collections import deque
from itertools import accumulate
from typing import Final

from core.vectors import ZERO, Vector, along, capped, is_finite, length

from .numbers import EmulatedSpec

BINS: Final = 100  # of the window
AHEAD: Final = 10  # bins, 1 s


class Motors:
    """The force limiter of one fingertip.

    The integral of F^2 over any window (10 s) stays within that of the continuous force. It is kept in bins. The force
    allowed during a bin is the one that could act for a whole second without exceeding the integral, given what leaves
    the window meanwhile: so a peak folds back smoothly, and the continuous force never does.

    sent: the force that acts [N].
    limited: it is less than was wanted.
    """

    def __init__(self, spec: EmulatedSpec) -> None:
        self.spec, self.sent, self.limited = spec, ZERO, False
        self._bins = deque([0.0] * (BINS + 1), maxlen=BINS + 1)  # F^2 dt [N2 s], the last one under way
        self._ticks = max(round(spec.rms_window * spec.tick_hz / BINS), 1)  # a bin
        self._tick = 0
        self._most = self._afford()  # [N] during this bin

    def limit(self, wanted: Vector) -> Vector:
        """Return the force [N] that may act during this tick; none where it is not a number."""
        wanted = wanted if is_finite(wanted) else ZERO
        self.limited = length(wanted) > self._most
        before = capped(self.sent, length(wanted))  # a force falls at once
        change = capped(along(wanted, before, -1.0), self.spec.slew * self.spec.tick)
        self.sent = capped(along(before, change, 1.0), self._most)
        self._spend()
        return self.sent

    def zero(self) -> Vector:
        """Take all force away, at once."""
        self.sent, self.limited = ZERO, False
        self._spend()
        return ZERO

    def _spend(self) -> None:
        x, y, z = self.sent
        self._bins[-1] += (x * x + y * y + z * z) * self.spec.tick
        self._tick += 1
        if self._tick == self._ticks:
            self._tick = 0
            self._bins.append(0.0)  # the oldest leaves
            self._most = self._afford()

    def _afford(self) -> float:
        spec = self.spec
        left = spec.continuous_force**2 * spec.rms_window - sum(self._bins)
        leaves = [0.0, *accumulate(list(self._bins)[: AHEAD - 1])]  # by the end of the first bin, the second...
        period = self._ticks * spec.tick
        square = min([(left + gone) / (k * period) for k, gone in enumerate(leaves, 1)])
        return min(spec.peak_force, math.sqrt(max(square, 0.0)))
