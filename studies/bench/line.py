"""One direction of an emulated serial line: bytes take their time at the baud rate."""

from __future__ import annotations

import math
from collections import deque

from .numbers import BITS_A_BYTE


class EmulatedLine:
    """Carry frames one way.

    Args:
        baud: bits a second; 0: bytes take no time.
    """

    def __init__(self, baud: int) -> None:
        self._byte = BITS_A_BYTE / baud if baud else 0.0
        self._queue: deque[tuple[float, bytes]] = deque()  # when its first byte leaves [s], bytes
        self._free = 0.0  # when the line is free again [s]

    def send(self, now: float, frame: bytes) -> None:
        """Put a frame on the line at a time [s], behind those under way."""
        start = max(now, self._free)
        self._free = start + len(frame) * self._byte
        self._queue.append((start, frame))

    def take(self, now: float) -> bytes:
        """Return the bytes that have arrived by a time [s]."""
        arrived = []
        while self._queue:
            start, data = self._queue[0]
            whole = now + 1e-9 >= start + len(data) * self._byte
            n = len(data) if whole else max(int((now - start) / self._byte), 0) if self._byte else 0
            if n:
                arrived.append(data[:n])
            if not whole:
                if n:
                    self._queue[0] = (start + n * self._byte, data[n:])
                break
            self._queue.popleft()
        return b"".join(arrived)

    def next_time(self) -> float:
        """Return when the frame under way will have arrived [s], inf when there is none."""
        if not self._queue:
            return math.inf
        start, data = self._queue[0]
        return start + len(data) * self._byte
