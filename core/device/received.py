"""How many STATEs of the device arrived and how many were lost, by their sequence numbers."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from .limits import LOSS_FRAMES


@dataclass(slots=True)
class Received:
    """Counts of STATEs: used, missing in the sequence, and stale (older than the newest, or seen before).

    recent: of the last LOSS_FRAMES that were sent, when each came [s] and the number that were missing before it.
    sent: the number of these.
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
        """Count a STATE, and the number that were missing before it."""
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
        """Return the rate of the last STATEs [1/s], 0 of too few."""
        passed = self.recent[-1][0] - self.recent[0][0] if len(self.recent) >= LOSS_FRAMES / 10 else 0.0
        return (len(self.recent) - 1) / passed if passed > 0 else 0.0
