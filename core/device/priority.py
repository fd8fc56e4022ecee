"""Requests for priority and for processors that stay awake, for 1 kHz beside a Blender that is busy or idle."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from .limits import PRIORITY

WAKE_LATENCY: Final = Path("/dev/cpu_dma_latency")  # Linux: while it is open, it limits how deeply processors sleep


def keep_processors_awake() -> int | None:
    """Keep processors from sleeping between two ticks: waking takes milliseconds on a virtual machine.

    Return a descriptor that keeps them awake while it is open; None if the system refuses.
    """
    try:
        held = os.open(WAKE_LATENCY, os.O_WRONLY)
        os.write(held, bytes(4))  # a wake-up latency of 0 us
    except OSError:
        return None
    return held


def request_priority() -> bool:
    """Request real-time priority; return whether it was granted.

    On Windows the parent requests it when it starts the process (process.start); elsewhere an ordinary account may be
    refused.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
        return True
    except (AttributeError, OSError):
        return False
