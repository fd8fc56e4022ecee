"""What servo and emulator ask of the system: without it they are late beside a busy Blender, or beside an idle one."""

import os
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from core.device import priority
from core.device.priority import WAKE_LATENCY
from tests.haptics.machine import unable
from tools.environment import ROOT

ASK = """
import os, sys
sys.path.append(sys.argv[1])
from core.device.priority import request_priority
print(request_priority(), os.sched_getscheduler(0) == os.SCHED_FIFO, sep=",")
"""

KEEP_AWAKE = """
import sys
sys.path.append(sys.argv[1])
from core.device.priority import keep_processors_awake
print(keep_processors_awake() is not None, flush=True)
sys.stdin.read()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the scheduler is read as Linux has it")
def test_the_system_does_what_it_says_it_granted() -> None:
    """In a process of its own, for the priority stays."""
    command = [sys.executable, "-I", "-S", "-c", ASK, str(ROOT)]
    granted, real_time = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip().split(",")
    assert real_time == granted
    if granted != "True":
        unable("this machine grants no real-time priority")


@pytest.mark.skipif(not os.access(WAKE_LATENCY, os.R_OK | os.W_OK), reason="the system lets nobody ask for this")
def test_processors_stay_awake_while_the_process_lives() -> None:
    command = [sys.executable, "-I", "-S", "-c", KEEP_AWAKE, str(ROOT)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin and process.stdout
        assert process.stdout.readline().strip() == "True"
        with open(WAKE_LATENCY, "rb") as file:
            (latency,) = struct.unpack("i", file.read(4))  # the least that any process has asked for [us]
        process.kill()
    assert latency == 0


def test_an_account_that_may_not_ask_goes_without(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(priority, "WAKE_LATENCY", tmp_path / "not there")
    assert priority.keep_processors_awake() is None
