"""Wait for bytes without asking a terminal whether it has some.

On Linux that question (select, or a read where nothing is) waits for the system's own worker that brings the bytes.
A process that goes before others takes the processor from that worker just as it is told of them; then whoever else
computes there keeps the worker, and so the question, waiting for 1 to 4 ms. A terminal that tells when bytes have come
(edge-triggered) need not be asked.
"""

from __future__ import annotations

import os
import select
from typing import Final

EDGES: Final = hasattr(select, "epoll")
MILLISECOND: Final = 1e-3
MOST: Final = 65536  # bytes at once


class Arrivals:
    """Watch descriptors. Each is named once for all that has come since, and when its other end is gone."""

    def __init__(self, *descriptors: int) -> None:
        self._descriptors = descriptors
        if EDGES:
            self._told = select.epoll()
            for each in descriptors:
                self._told.register(each, select.EPOLLIN | select.EPOLLET)

    def wait(self, seconds: float) -> list[int]:
        """Return those where bytes have come, after so long [s] at most."""
        if not EDGES:
            return select.select(self._descriptors, [], [], seconds)[0]
        if seconds < MILLISECOND:  # epoll counts in whole ones
            select.select([self._told], [], [], seconds)
            seconds = 0
        return [each for each, _ in self._told.poll(seconds)]


def take(descriptor: int) -> bytes:
    """Return the bytes that are there, b"" where there are none."""
    try:
        return os.read(descriptor, MOST)
    except BlockingIOError:
        return b""
