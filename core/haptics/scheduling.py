"""Ask the system for priority: 1 kHz beside a busy Blender."""

from __future__ import annotations

import os
from typing import Final

PRIORITY: Final = 10  # of the first-in-first-out class: above every ordinary process, below the system's own
NICENESS: Final = -20  # the strongest there is


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
        os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
        return "nice"
    except (AttributeError, OSError):
        return ""
