"""Priority for servo and emulator: without it they are late beside a busy Blender."""

import subprocess
import sys

import pytest

from tests.haptics.machine import unable
from tools.environment import ROOT

ASK = """
import os, sys
sys.path.append(sys.argv[1])
from core.haptics.scheduling import request_priority
print(request_priority(), os.sched_getscheduler(0) == os.SCHED_FIFO, os.getpriority(os.PRIO_PROCESS, 0), sep=",")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the scheduler is read as Linux has it")
def test_the_system_does_what_it_says_it_granted() -> None:
    """In a process of its own, for the priority stays."""
    command = [sys.executable, "-I", "-S", "-c", ASK, str(ROOT)]
    granted, real_time, niceness = (
        subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip().split(",")
    )
    assert (real_time == "True") == (granted == "real time")
    assert (int(niceness) == -20) == (granted == "nice")
    if granted != "real time":
        unable("this machine grants no real-time priority")
