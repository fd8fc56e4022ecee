"""An emulated device in a process of its own, its fingertips pressed into a wall through the real servo.

What must hold on time is judged on the device's own clock, by its trace: a busy machine changes nothing there. What
processes do to each other is waited for, for as long as such a machine takes.
"""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.device import wire
from core.device.device import Device
from core.device.force_guard import Arming
from core.device.orders import LinkState, ServoReport
from core.device.process import end
from core.vectors import length
from studies.bench.processes import START_TIME, _free_port, start_emulator
from tests.haptics.bench_device import wall
from tests.haptics.host import SPEC
from tests.haptics.machine import UNABLE, unable

SIDES = ((-0.04, 0.0), (0.02, 0.035), (0.02, -0.035))  # [m] of the fingertips
BEGIN = 1.2  # [s] after the device's ramp begins, when the servo's is over too
# the hand lifts now and then: a fingertip that sank in while the device had no commands meets a soft body until then
LIFTS = [(at + 0.35, at + 2.85, at + 3.0) for at in (BEGIN + 3.2 * i for i in range(10))]
WAY = [[0.0, 0.0, 0.0, 0.01], [BEGIN + 0.2, 0.0, 0.0, 0.01]]
WAY += [
    [t, 0.0, 0.0, z]
    for down, still, up in LIFTS
    for t, z in ((down, -0.01), (still, -0.01), (up, 0.01), (up + 0.2, 0.01))
]
PATIENCE = 30.0  # [s] on a busy machine
AGAIN = 0.5  # [s] between two requests to arm
LASTING = 0.7  # [s] the device's ramp takes 0.5 s
BUSY = 0.01  # of the positions; a machine that can do anything else loses none
PRESSED = 0.5  # [N] of the 1.7 N that a quiet machine presses: a slow one renders softer walls
LETS_GO = 75  # [ticks] before the watchdog latches there must be no force: by 25 ms of 100 ms


@dataclass
class Rig:
    """An emulator behind a port."""

    folder: Path
    process: subprocess.Popen[bytes]
    port: str
    secret: str = "a secret of this test alone"

    def stop(self) -> float:
        """End the emulator; return when, on the system's clock [s]."""
        now = time.perf_counter()
        end(self.process)
        return now

    def force_left(self) -> float:
        """Return the largest force [N] that is not the brake's from when there must be none after the last press.

        After a DISARM that is at once. Without a Command it is 25 ms after the last one, so 75 ms before the device
        latches its fault, and what acts then is a brake: at most as strong as the last 20 ms were fast.
        """
        rows = np.loadtxt(self.folder / "trace.csv", delimiter=",", skiprows=1)
        places, forces = rows[:, 2:11].reshape(-1, 3, 3), np.linalg.norm(rows[:, 11:20].reshape(-1, 3, 3), axis=2)
        if self.port.startswith("haply"):  # no force from the end of the connection on
            return float(forces[-20:].max())
        armed = np.isin(rows[:, 1], (wire.RAMP, wire.ARMED))
        pressed = np.flatnonzero(armed & (forces.min(axis=1) > 0.8 * PRESSED))
        if not len(pressed):
            unable("this machine cannot run a loop of 1 kHz: the device let go too early")
        ended = pressed[-1] + np.flatnonzero(~armed[pressed[-1] :])[0]
        if rows[ended, 1] == wire.IDLE:
            return float(forces[ended : ended + 100].max())
        return float(_without_brake(places, forces)[ended - LETS_GO : ended + 100].max())

    def force_after(self, time: float) -> float:
        """Return the largest force [N] that is not the brake's after a time of the device [s]."""
        rows = np.loadtxt(self.folder / "trace.csv", delimiter=",", skiprows=1)
        places, forces = rows[:, 2:11].reshape(-1, 3, 3), np.linalg.norm(rows[:, 11:20].reshape(-1, 3, 3), axis=2)
        return float(_without_brake(places, forces)[rows[:, 0] > time].max(initial=0.0))


def _without_brake(places: np.ndarray, forces: np.ndarray) -> np.ndarray:
    speeds = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=2) / SPEC.tick
    return forces - SPEC.brake * np.max([np.roll(speeds, back, axis=0) for back in range(20)], axis=0)


def rig(folder: Path, *words: str, line: str = "pty") -> Rig:
    """Start an emulator whose hand presses 10 mm deep once there is force, each fingertip at a place of its own.

    line: "pty", "udp" or "haply".
    """
    hand = folder / "hand.json"
    hand.write_text(json.dumps({"tips": [[[t, x, y, z] for t, _, _, z in WAY] for x, y in SIDES]}))
    files = ["--hand", str(hand), "--trace", str(folder / "trace.csv"), *words]
    if line != "pty":
        number = _free_port()
        made = Rig(folder, start_emulator([f"--{line}", str(number), *files], secret=Rig.secret), f"{line}:{number}")
        made.port = f"udp:127.0.0.1:{number}" if line == "udp" else made.port
        time.sleep(2 * START_TIME)
        return made
    made = Rig(folder, start_emulator(["--pty", str(folder / "port"), *files]), str(folder / "port"))
    until = time.perf_counter() + PATIENCE
    while not os.path.exists(made.port) and time.perf_counter() < until:
        time.sleep(0.01)
    return made


def drive(
    device: Device, until: Callable[[ServoReport], bool], *, k: float = 300.0, arms: bool = False
) -> ServoReport:
    """Play the simulation, 60 times a second, until something has happened; the wall is there once there is force.

    arms: hold the dead-man key and ask for force, again where a busy machine was disarmed for its gaps.
    """
    asked = -math.inf
    for _ in range(round(60 * PATIENCE)):  # frames, for a busy machine may stand still for longer
        if until(report := device.read()):
            return report
        now = time.perf_counter()
        if arms and report.arming is Arming.OFF and now - asked > AGAIN:
            asked = now
            device.hold(math.inf)
            device.arm()
        device.write([wall(now, k=k) if report.arming in (Arming.RAMP, Arming.ON) else None] * 3)
        time.sleep(1 / 60)
    if report.lost > BUSY * report.states:
        unable(f"this machine cannot run a loop of 1 kHz: {report.lost} of {report.states} positions were lost")
    raise AssertionError(report)


def gone(pid: int) -> bool:
    """Tell whether a process ends."""
    for _ in range(1000):
        status = Path(f"/proc/{pid}/stat")
        if not status.exists() or status.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.01)
    return False


def ready(report: ServoReport) -> bool:
    return report.link is not LinkState.OPENING and bool(report.states or report.link is not LinkState.READY)


def pressed() -> Callable[[ServoReport], bool]:
    """Return what tells whether the hand has pressed for as long as a device takes to ramp its force up, and more."""
    since = math.inf

    def there(report: ServoReport) -> bool:
        nonlocal since
        now = time.perf_counter()
        all_press = len(report.tips) == 3 and min(length(tip.force) for tip in report.tips) > PRESSED
        since = min(since, now) if all_press and report.arming is Arming.ON else math.inf
        return now - since > LASTING

    return there


def press(device: Device) -> ServoReport:
    """Connect, arm and wait until the hand has pressed."""
    for _ in range(3):  # again where the machine stood still for the second in which a device must answer
        device.open()
        if drive(device, ready).link is LinkState.READY:
            break
        device.close()
    return drive(device, pressed(), arms=True)


if __name__ == "__main__":  # what Blender is in the tests that kill it
    device = Device(sys.argv[1], secret=sys.argv[2])
    try:
        press(device)
    except UNABLE as busy:
        sys.exit(f"{busy}")
    print(device.process.pid if device.process else 0, flush=True)
    drive(device, lambda _: False)
