"""How many STATEs arrived and how many were lost, by their sequence numbers."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

LOSS_TIME = 1.0  # [s] over which the share is taken
LOSS_FEWEST = 100  # frames, before a share means anything
LOSS_WARNS, LOSS_DISARMS = 0.05, 0.30  # shares


@dataclass(slots=True)
class Losses:
    """Counts of STATEs.

    taken: arrived and used.
    missing: missing in the sequence.
    stale: older than the newest, or seen before.
    began: when the session did [s].
    recent: of the last second, when each came [s] and how many were missing before it.
    recent_missing: how many of the last second were missing.
    """

    taken: int = 0
    missing: int = 0
    stale: int = 0
    began: float = -math.inf
    recent: deque[tuple[float, int]] = field(default_factory=deque)
    recent_missing: int = 0

    def restart(self, now: float) -> None:
        """Begin a session; the counts continue."""
        self.began, self.recent_missing = now, 0
        self.recent.clear()

    def take(self, missing: int, now: float) -> None:
        """Count a STATE, and how many were missing before it."""
        self.taken += 1
        self.missing += missing
        self.recent.append((now, missing))
        self.recent_missing += missing
        while self.recent[0][0] < now - LOSS_TIME:
            self.recent_missing -= self.recent.popleft()[1]

    @property
    def share(self) -> float:
        """Return the share of the last second's STATEs that is missing."""
        whole = len(self.recent) + self.recent_missing
        return self.recent_missing / whole if whole >= LOSS_FEWEST else 0.0

    @property
    def rate(self) -> float:
        """Return how many STATEs came a second [1/s], over the last one."""
        if len(self.recent) < 2:
            return 0.0
        return (len(self.recent) - 1) / max(self.recent[-1][0] - self.recent[0][0], 1e-6)
