"""Wait for bytes without asking a terminal whether it has some.

On Linux that question (select, or a read where nothing is) waits for the system's own worker that brings the bytes.
A process that goes before others takes the processor from that worker just as it is told of them; then whoever else
computes there keeps the worker, and so the question, waiting for 1 to 4 ms. A terminal that tells when bytes have come
(edge-triggered) need not be asked.
"""

from __future__ import annotations

import select
from typing import Final

EDGES: Final = hasattr(select, "epoll")


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
        if not select.select([self._told], [], [], seconds)[0]:  # epoll itself counts in whole milliseconds
            return []
        return [each for each, _ in self._told.poll(0)]
