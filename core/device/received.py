"""The numbers of STATEs that arrived from the device and that were lost, by their sequence numbers."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from .limits import LOSS_FRAMES


@dataclass(slots=True)
class Received:
    """Counts of STATEs: taken, missing in the sequence, and stale (older than the newest, or duplicates).

    recent: for each that arrived of the last LOSS_FRAMES sent, its time [s] and the number missing before it.
    sent: number of STATEs that `recent` covers, the missing ones included.
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
        """Return the share of the recent STATEs that is missing, 0 if they are too few."""
        return 1 - len(self.recent) / self.sent if self.sent >= LOSS_FRAMES / 10 else 0.0

    @property
    def rate(self) -> float:
        """Return the rate of the recent STATEs [1/s], 0 if they are too few."""
        passed = self.recent[-1][0] - self.recent[0][0] if len(self.recent) >= LOSS_FRAMES / 10 else 0.0
        return (len(self.recent) - 1) / passed if passed > 0 else 0.0
