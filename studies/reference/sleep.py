"""Bodies at rest sleep: they are not stepped until something wakes them, and go on from the very state they were in.

A body falls asleep when for REST_TIME it has been slower than REST_SPEED, or in place, and no vertex is farther than
ROUNDING from where it was when that began. A velocity alone does not move it: contact may hold it back, and a short
step is lost in rounding. Its velocities stay as they are, so neither position nor velocity jumps when it wakes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from core.base import Floats

from .constants import NEAR, REST_SPEED, REST_TIME, ROUNDING


@dataclass(slots=True)
class Rest:
    """How long a body has been at rest.

    quiet: [s] since it became slow, or stayed in place.
    still: (3, n) where it was then [m].
    rested: it may sleep.
    asleep: it is not stepped.
    under: fingertips that were near when it fell asleep: where (3,) [m] and their radius [m].
    """

    quiet: float = 0.0
    still: Floats | None = None
    rested: bool = False
    asleep: bool = False
    under: dict[int, tuple[Floats, float]] = field(default_factory=dict)

    def watch(self, x: Floats, v: Floats, size: float, tick: float, *, led: bool) -> None:
        """Look at a body (3, n) [m], [m/s] after a tick [s].

        Args:
            led: its pins were.
        """
        speed = float(np.sqrt((v * v).sum(axis=0).max(initial=0)))
        goes = speed > REST_SPEED * size and self.quiet > 0 and not self._stays(x, size)
        if led or goes:
            self.quiet, self.rested = 0.0, False
            return
        if self.still is None or self.quiet == 0:
            self.still = x.copy()
        self.quiet += tick
        if self.quiet < REST_TIME:
            return
        self.quiet, self.rested = 0.0, self._stays(x, size)

    def _stays(self, x: Floats, size: float) -> bool:
        way = x - (x if self.still is None else self.still)
        return bool(np.sqrt((way * way).sum(axis=0).max(initial=0)) <= ROUNDING * size)

    def lies_under(self, finger: int, centre: Floats, radius: float) -> bool:
        """Tell whether a fingertip is where it was when the body fell asleep."""
        if finger not in self.under:
            return False
        before, size = self.under[finger]
        return size == radius and float(np.linalg.norm(centre - before)) <= ROUNDING * radius


def reaches(x: Floats, start: Floats, end: Floats, radius: float) -> bool:
    """Tell whether a fingertip going from start to end (3,) in a tick comes near the box of a body (3, n) [m]."""
    gap = np.maximum(np.maximum(x.min(axis=1) - end, end - x.max(axis=1)), 0)
    return float(np.linalg.norm(gap)) < (1 + NEAR) * radius + 2 * float(np.linalg.norm(end - start))
