"""Wait for bytes without asking a terminal whether it has some.

On Linux that question (select, or a read where nothing is there) waits for the kernel worker that delivers the bytes.
A real-time process takes the processor from that worker just as it is notified; whatever else computes there then
keeps the worker, and so the question, waiting for 1 to 4 ms. A terminal that is watched edge-triggered need not be
asked.
"""

from __future__ import annotations

import os
import select
from typing import Final

EDGE_TRIGGERED: Final = hasattr(select, "epoll")
MAX_BYTES: Final = 65536  # read at once


class Poller:
    """Watch descriptors. Each is returned once for all that has come since, and when its other end is gone."""

    def __init__(self, *descriptors: int) -> None:
        self._descriptors = descriptors
        if EDGE_TRIGGERED:
            self._epoll = select.epoll()
            for each in descriptors:
                self._epoll.register(each, select.EPOLLIN | select.EPOLLET)

    def wait(self, seconds: float) -> list[int]:
        """Return the descriptors where bytes have come, after so long [s] at most."""
        if not EDGE_TRIGGERED:
            return select.select(self._descriptors, [], [], seconds)[0]
        if seconds < 1e-3:  # epoll counts in milliseconds
            select.select([self._epoll], [], [], seconds)
            seconds = 0
        return [each for each, _ in self._epoll.poll(seconds)]


def take(descriptor: int) -> bytes:
    """Return the bytes that are there, b"" where there are none."""
    try:
        return os.read(descriptor, MAX_BYTES)
    except BlockingIOError:
        return b""
