"""The last limits before a motor: length of the force, its change, and the heat of ten seconds."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Final

from .spec import Spec
from .vectors import ZERO, Vector, along, capped, is_finite, length

BINS: Final = 100  # of the window
FOLD: Final = 1.0  # [s] how fast the force folds back when the window's budget ends


@dataclass(slots=True)
class Motors:
    """Limit the force of one fingertip.

    The sum of F^2 dt over the window (10 s) never exceeds its budget, that of the continuous force: what may act now
    is the square root of what is left over FOLD. sent: the force that acts [N].  limited: less than was wanted.
    """

    spec: Spec
    sent: Vector = ZERO
    limited: bool = False
    _bins: deque[float] = field(default_factory=lambda: deque([0.0], maxlen=BINS + 1))  # [N2 s]
    _used: float = 0.0  # [N2 s] their sum
    _tick: int = 0

    def limit(self, wanted: Vector) -> Vector:
        """Return the force [N] that may act for this tick; no number, no force."""
        spec = self.spec
        wanted = wanted if is_finite(wanted) else ZERO
        left = spec.continuous_force**2 * spec.rms_window - self._used
        most = min(spec.peak_force, math.sqrt(max(left, 0.0) / FOLD))
        self.limited = length(wanted) > most
        change = capped(along(capped(wanted, most), self.sent, -1.0), spec.slew * spec.tick)
        self.sent = capped(along(self.sent, change, 1.0), most)
        self._spend()
        return self.sent

    def zero(self) -> Vector:
        """Take all force away, at once."""
        self.sent, self.limited = ZERO, False
        self._spend()
        return ZERO

    def _spend(self) -> None:
        spec = self.spec
        x, y, z = self.sent
        energy = (x * x + y * y + z * z) * spec.tick
        self._bins[-1] += energy
        self._used += energy
        self._tick += 1
        if self._tick >= spec.rms_window * spec.tick_hz / BINS:
            self._tick = 0
            self._bins.append(0.0)  # the oldest leaves
            self._used = sum(self._bins)
