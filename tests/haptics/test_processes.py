"""Processes that die during a press: no force, no orphan, no stuck port, a new ARM.

When the force must be gone is judged on the device's clock; that Blender hears of it in 100 ms is judged on an injected
clock (test_servo_link.py). Here it is waited for.
"""

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from core.base import DimpleError
from core.device import wire
from core.device.device import Device
from core.device.force_guard import Arming
from core.device.notes import FAULTS, NO_ANSWER, SILENT, STOOD_STILL, WAS_SILENT
from core.device.orders import LinkState, ServoReport
from core.vectors import length
from studies.device import haptics
from tests.haptics.machine import NEEDS_PTY, unable
from tests.haptics.pressing import PATIENCE, Rig, drive, gone, press, pressed, ready, rig
from tests.haptics.test_firmware import BRAKE_NOISE, CONVERTERS
from tools.environment import ROOT

pytestmark = NEEDS_PTY
# the notes where processes get no processor: for 1 s at first, for 100 ms, for 5 of every 50 ms while it arms
ARMS_ANEW = "At the end it was arming anew."  # what a lapse of the dead-man key leads to is no fault, so has no note
STALLS = (
    ARMS_ANEW, SILENT, WAS_SILENT, STOOD_STILL, FAULTS[wire.FAULT_WATCHDOG], FAULTS[wire.FAULT_ARM_REFUSED],
    "The emulated device did not arm.", "the machine is too busy", NO_ANSWER.partition(".")[0],
)  # fmt: skip
NOISE = BRAKE_NOISE + CONVERTERS  # [N] of the 1.7 N pressed


@pytest.fixture
def emulator(tmp_path: Path) -> Iterator[Rig]:
    made = rig(tmp_path)
    yield made
    made.stop()


def needs_a_new_arm(port: str) -> bool:
    """Tell whether the port is free, and a new connection has no force until it is requested."""
    device = Device(port)
    device.open()
    try:
        report = drive(device, ready)
        begun = time.perf_counter()
        report = drive(device, lambda _: time.perf_counter() - begun > 0.3)
        unarmed = report.arming is Arming.OFF and not any(length(tip.force) for tip in report.tips)
        drive(device, lambda report: report.arming is not Arming.OFF, k=0.0, arms=True)
        return unarmed
    finally:
        device.close()


def test_blender_is_killed(emulator: Rig) -> None:
    """Its pipe closes: the servo tells the device to let go, and ends."""
    blender = subprocess.Popen(
        [sys.executable, "-m", "tests.haptics.pressing", emulator.port, emulator.secret],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT,
    )  # fmt: skip
    assert blender.stdout and blender.stderr
    line = blender.stdout.readline()
    if not line and (why := blender.stderr.read().decode()).startswith("this machine"):
        unable(why)
    servo = int(line)
    blender.kill()
    blender.wait()
    assert gone(servo)
    assert needs_a_new_arm(emulator.port)
    emulator.stop()
    assert emulator.force_left() == 0.0


def test_the_servo_is_killed(emulator: Rig) -> None:
    """The device lets go by itself and latches the fault; Blender reads on and reports it."""
    device = Device(emulator.port)
    press(device)
    assert device.process
    device.process.send_signal(signal.SIGKILL)
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert "arm again" in report.note
    device.close()
    time.sleep(0.5)  # until the device has latched
    assert needs_a_new_arm(emulator.port)
    emulator.stop()
    assert emulator.force_left() < NOISE


def test_the_servo_hangs(emulator: Rig) -> None:
    """The device lets go by itself; Blender reports it, and ends the servo."""
    device = Device(emulator.port)
    press(device)
    assert device.process
    pid = device.process.pid
    device.process.send_signal(signal.SIGSTOP)
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.arming is Arming.OFF and "does not answer" in report.note
    assert gone(pid)
    device.close()
    assert needs_a_new_arm(emulator.port)
    emulator.stop()
    assert emulator.force_left() < NOISE


@pytest.mark.slow
@pytest.mark.parametrize("victim", ["Blender", "servo", "device"])
@pytest.mark.parametrize("line", ["pty", "udp", "haply"])
def test_ten_kills_at_random_moments_leave_no_force_and_no_process(tmp_path: Path, line: str, victim: str) -> None:
    dice = random.Random(line + victim)
    for i in range(10):
        folder = tmp_path / str(i)
        folder.mkdir()
        made = rig(folder, line=line)
        blender = subprocess.Popen(
            [sys.executable, "-m", "tests.haptics.pressing", made.port, made.secret],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT,
        )  # fmt: skip
        assert blender.stdout and blender.stderr
        servo = int(blender.stdout.readline() or unable(blender.stderr.read().decode()[-500:]))
        time.sleep(dice.uniform(0.0, 1.5))
        os.kill({"Blender": blender.pid, "servo": servo, "device": made.process.pid}[victim], signal.SIGKILL)
        if victim == "Blender" or (victim == "device" and line != "udp"):  # a device on a network may come back
            assert gone(servo)
        time.sleep(0.3)  # until the device has let go
        blender.kill()
        blender.wait()
        assert gone(servo)
        if victim != "device":
            made.stop()
            assert made.force_left() < NOISE


GO_ON = "flip garbage truncate drop duplicate reorder".split()
END = "delay=0.03 stale wrong-baud unplug stall adc-range adc-frozen adc-jump".split()


@pytest.mark.slow
@pytest.mark.parametrize("fault", GO_ON + END)
@pytest.mark.parametrize("line", ["pty", "udp"])
def test_every_fault_by_either_line(tmp_path: Path, line: str, fault: str) -> None:
    """A line that errs now and then presses on; what must end the force ends it, after 54 ms where a sensor freezes."""
    begun = time.perf_counter()
    when = "@8+1" if fault == "stale" else "@8"  # what waits must come some time
    made = rig(tmp_path, "--fault", fault + when, "--seconds", "9.5", line=line)
    device = Device(made.port, secret=made.secret)
    press(device)
    report = drive(device, lambda _: time.perf_counter() - begun > 9.0)
    device.close()
    made.process.wait(PATIENCE)  # until it has written its trace
    if fault in END:
        assert report.arming is not Arming.ON and made.force_after(8.06) < NOISE
    elif report.arming is not Arming.ON:
        unable(f"this machine stands still for too long: {report.note}")


def test_the_mailbox_is_out_of_sight_once_both_have_it(emulator: Rig) -> None:
    """So that none is left whichever process is killed; it is mapped, and goes on."""
    device = Device(emulator.port)
    device.open()
    drive(device, ready)
    assert device._box and not device._box.path.exists()
    assert drive(device, pressed(), arms=True).link is LinkState.READY
    device.close()


@pytest.mark.parametrize("how", ["killed", "unplugged"])
def test_the_device_goes_away(tmp_path: Path, how: str) -> None:
    """The servo reports the loss and ends; another device is started at the same path and found, unarmed."""
    made = rig(tmp_path)
    device = Device(made.port)
    press(device)
    assert device.process
    pid = device.process.pid
    if how == "killed":
        made.process.kill()
    else:
        made.stop()  # to the host it looks the same
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.note and report.arming is Arming.OFF
    assert gone(pid)
    assert os.path.islink(made.port) == (how == "killed")
    device.close()
    made.stop()
    again = rig(tmp_path)
    assert needs_a_new_arm(again.port)
    again.stop()


def test_a_second_opener_is_refused(emulator: Rig) -> None:
    first, second = Device(emulator.port), Device(emulator.port)
    first.open()
    drive(first, ready)
    second.open()
    report = drive(second, ready)
    assert report.link is LinkState.REFUSED and "in use" in report.note
    assert drive(first, lambda report: report.link is LinkState.READY).link is LinkState.READY, "the first goes on"
    for device in (second, first):
        device.close()


def test_another_protocol_is_refused_naming_both(tmp_path: Path) -> None:
    made = rig(tmp_path, "--fault", "version=3")
    device = Device(made.port)
    device.open()
    report = drive(device, ready)
    assert report.link is LinkState.REFUSED and "3.0" in report.note and "2.0" in report.note
    device.close()
    made.stop()


def test_a_wrong_baud_rate_is_reported(tmp_path: Path) -> None:
    made = rig(tmp_path, "--fault", "wrong-baud")
    device = Device(made.port)
    device.open()
    assert "baud" in drive(device, ready).note
    device.close()
    made.stop()


@pytest.mark.parametrize("data", [b"", b"\x55" * 4096, bytes(range(256)) * 16], ids=["nothing", "no end", "noise"])
def test_a_port_with_something_else_behind_it_is_refused_within_a_second(data: bytes) -> None:
    """One that is silent, one that never ends a frame, one that sends noise; the servo ends each time."""
    master, slave = os.openpty()
    os.set_blocking(master, False)
    device = Device(os.ttyname(slave))
    device.open()
    assert device.process
    pid = device.process.pid

    def answered(report: ServoReport) -> bool:
        with contextlib.suppress(BlockingIOError):
            os.write(master, data)
        return report.link is not LinkState.OPENING

    report = drive(device, answered)
    assert report.link is LinkState.REFUSED and "Nothing answered within 1 s" in report.note
    assert gone(pid)
    device.close()
    os.close(master)
    os.close(slave)


def test_five_seconds_behind_a_real_pseudo_terminal() -> None:
    """Bounds that a busy machine keeps too; the goals are for a quiet one, and `dev.py core haptics` shows them."""
    for _ in range(6):
        try:
            trial = haptics.press(5.0)
            figures = haptics.judge(trial)
            whole = trial.report.arming is Arming.ON and figures["ramps"] == 1
            why = None if whole else trial.report.note or ARMS_ANEW
        except DimpleError as error:
            why = str(error)
        if why is None:
            break
        assert any(stall in why for stall in STALLS), why
    else:
        unable(f"this machine stands still for too long again and again: {why}")
    print(figures)
    assert figures["rate_hz"] > 200
    assert figures["wrong_frames"] == 0
    assert 0.05 < figures["tip_rms_error_mm"] < 0.2  # the converters' own steps are 0.08
    assert 1.0 < figures["force_largest_n"] < 10.0
    assert 0.1 < figures["stiffness_rendered_n_m"] / haptics.PRESET.material.K1 < 1.25
