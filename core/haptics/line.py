"""One way of a serial line, emulated: bytes take their time at the baud rate, and what can go wrong with them does."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Sequence

from .faults import Fault
from .spec import BITS_A_BYTE


class Line:
    """Carry frames one way.

    Args:
        baud: bits a second; 0: bytes take no time.  faults: those of this way.  dice: for them.
    """

    def __init__(self, baud: int, faults: Sequence[Fault], dice: random.Random) -> None:
        self._byte = BITS_A_BYTE / baud if baud else 0.0
        self._faults, self._dice = faults, dice
        self._queue: deque[tuple[float, bytes]] = deque()  # when its first byte sets off [s], bytes
        self._free = 0.0  # when the line is [s]
        self._held: list[bytes] = []  # a frame that comes after the next one

    def send(self, now: float, frame: bytes) -> None:
        """Put a frame on the line at a time [s]."""
        start, frames = now, [frame]
        for fault in self._faults:
            if fault.acts(now):
                frames = self._spoil(fault, frames)
                start += fault.value if fault.name == "delay" else 0.0
                start = max(start, fault.stop) if fault.name == "stale" else start
        for each in frames:
            start = max(start, self._free)
            self._free = start + len(each) * self._byte
            self._queue.append((start, each))

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
        """Return when the frame under way will have arrived [s], inf when none is."""
        if not self._queue:
            return math.inf
        start, data = self._queue[0]
        return start + len(data) * self._byte

    def _spoil(self, fault: Fault, frames: list[bytes]) -> list[bytes]:
        if fault.name == "flip":
            return [self._flip(frame, fault.value) for frame in frames]
        if fault.name == "wrong-baud":
            return [self._dice.randbytes(len(frame)) for frame in frames]
        if fault.name in ("delay", "stale") or self._dice.random() >= fault.value:
            return [*frames, *self._release()] if fault.name == "reorder" else frames
        if fault.name == "garbage":
            return [self._dice.randbytes(self._dice.randint(1, 60)), *frames]
        if fault.name == "truncate":
            return [frame[: self._dice.randrange(len(frame) + 1)] for frame in frames]
        if fault.name == "duplicate":
            return [*frames, *frames]
        if fault.name == "reorder":
            released, self._held = self._held, frames
            return released
        return []  # drop

    def _release(self) -> list[bytes]:
        held, self._held = self._held, []
        return held

    def _flip(self, frame: bytes, rate: float) -> bytes:
        # the way to the next error is geometric: one die a frame where nearly none is hit
        at = self._gap(rate)
        bits = 8 * len(frame)
        if at >= bits:
            return frame
        number = int.from_bytes(frame, "little")
        while at < bits:
            number ^= 1 << at
            at += 1 + self._gap(rate)
        return number.to_bytes(len(frame), "little")

    def _gap(self, rate: float) -> int:
        if not 0 < rate < 1:
            return 0 if rate else 1 << 60
        return int(math.log(1.0 - self._dice.random()) / math.log1p(-rate))
