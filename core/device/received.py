"""How many STATEs of the device arrived and how many were lost, by their sequence numbers."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from .limits import LOSS_FRAMES


@dataclass(slots=True)
class Received:
    """Counts of STATEs.

    taken: arrived and used.
    missing: missing in the sequence.
    stale: older than the newest, or seen before.
    recent: of the last LOSS_FRAMES that were sent, when each came [s] and how many were missing before it.
    sent: how many those are.
    """

    taken: int = 0
    missing: int = 0
    stale: int = 0
    recent: deque[tuple[float, int]] = field(default_factory=deque)
    sent: int = 0

    def restart(self) -> None:
        """Begin a session; the counts continue."""
        self.recent.clear()
        self.sent = 0

    def take(self, missing: int, now: float) -> None:
        """Count a STATE, and how many were missing before it."""
        self.taken += 1
        self.missing += missing
        self.recent.append((now, missing))
        self.sent += 1 + missing
        while self.sent > LOSS_FRAMES and len(self.recent) > 1:
            self.sent -= 1 + self.recent.popleft()[1]

    @property
    def lost_share(self) -> float:
        """Return the share of the last STATEs that is missing, 0 of too few."""
        return 1 - len(self.recent) / self.sent if self.sent >= LOSS_FRAMES / 10 else 0.0

    @property
    def rate(self) -> float:
        """Return how many of the last STATEs came a second [1/s]."""
        if len(self.recent) < LOSS_FRAMES / 10:
            return 0.0
        return (len(self.recent) - 1) / max(self.recent[-1][0] - self.recent[0][0], 1e-6)
