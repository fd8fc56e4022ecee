"""Ask the system to run a process before others: 1 kHz beside a busy Blender."""

from __future__ import annotations

import os

PRIORITY = 10  # of the first-come-first-served class: above every ordinary process, below the system's own
NICENESS = -20  # the least there is


def ask() -> str:
    """Ask for it; return what was granted: "real time", "nice" or "".

    Windows is asked when the process is started (process.start); other systems may say no to an ordinary account.
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
