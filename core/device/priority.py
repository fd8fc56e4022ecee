"""Ask the system for priority, and for processors that stay awake: 1 kHz beside a busy Blender, or an idle one."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from .limits import PRIORITY

WAKE_LATENCY: Final = Path("/dev/cpu_dma_latency")  # of Linux: whoever holds it open sets how deep processors may sleep


def keep_processors_awake() -> int | None:
    """Keep processors from sleeping between two ticks, which costs milliseconds on a virtual machine.

    Return a descriptor that keeps them awake while it is open; None where the system does not grant that.
    """
    try:
        held = os.open(WAKE_LATENCY, os.O_WRONLY)
        os.write(held, bytes(4))  # no latency at all [us]
    except OSError:
        return None
    return held


def request_priority() -> str:
    """Ask for priority; return what was granted: "real time", "nice" or "".

    On Windows the parent asks when it starts the process (process.start); elsewhere an ordinary account may be refused.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
        return "real time"
    except (AttributeError, OSError):
        pass
    try:
        os.setpriority(os.PRIO_PROCESS, 0, -20)  # the strongest there is
        return "nice"
    except (AttributeError, OSError):
        return ""
