"""An emulated device in a process of its own, its fingertips pressed into a wall through the real servo."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from core.devices.device import HapticMaster
from core.devices.letters import Link, Report
from core.devices.process import end, start
from core.devices.vectors import length
from tests.devices.bench_device import wall

BEGIN = 1.2  # [s] after the device's ramp begins, when the servo's is over too
WAY = [[0.0, 0.0, 0.0, 0.01], [BEGIN, 0.0, 0.0, 0.01], [BEGIN + 0.15, 0.0, 0.0, -0.01]]
PATIENCE = 8.0  # [s] on a busy machine
ACTS = 0.3  # [N] more than the brake of a finger at rest


@dataclass
class Rig:
    """Hold an emulator behind a port."""

    folder: Path
    process: subprocess.Popen[bytes]

    @property
    def port(self) -> str:
        return str(self.folder / "port")

    def stop(self) -> float:
        """End the emulator; return when, on the system's clock [s]."""
        now = time.perf_counter()
        end(self.process)
        return now

    def last_force(self, ended: float, at: float) -> float:
        """Return how long after a moment `at` the motors still pushed [s], by the device's own trace."""
        rows = [[*map(float, line.split(",")[2:]), float(line.split(",")[0])] for line in self._trace()]
        pushed = [row[-1] for row in rows if max(length(tuple(row[i : i + 3])) for i in (9, 12, 15)) > ACTS]
        return pushed[-1] - (rows[-1][-1] - (ended - at))

    def _trace(self) -> list[str]:
        return (self.folder / "trace.csv").read_text().splitlines()[1:]


def rig(folder: Path, *words: str) -> Rig:
    """Start an emulator whose hand presses 10 mm deep once there is force."""
    hand = folder / "hand.json"
    hand.write_text(json.dumps({"tips": [WAY] * 3}))
    (folder / "port").unlink(missing_ok=True)  # which a killed one leaves
    files = ["--pty", str(folder / "port"), "--hand", str(hand), "--trace", str(folder / "trace.csv")]
    made = Rig(folder, start(["emulator", *files, "--lifeline", *words], None))
    until = time.perf_counter() + PATIENCE
    while not os.path.lexists(made.port) and time.perf_counter() < until:
        time.sleep(0.01)
    return made


def drive(device: HapticMaster, until: Callable[[Report], bool], *, k: float = 300.0) -> Report:
    """Play the simulation, 60 times a second, until something has happened."""
    ends = time.perf_counter() + PATIENCE
    while not until(report := device.read()):
        assert time.perf_counter() < ends, report
        contact = replace(wall(time.perf_counter(), k=k), friction=0.0)
        device.write([contact] * 3)
        time.sleep(1 / 60)
    return report


def ready(report: Report) -> bool:
    return report.link is not Link.OPENING and bool(report.states or report.link is not Link.READY)


def pressed(report: Report) -> bool:
    return len(report.tips) == 3 and min(length(tip.force) for tip in report.tips) > 0.5


def press(device: HapticMaster) -> Report:
    """Connect, arm and wait until the hand has pressed."""
    device.open()
    drive(device, ready)
    device.arm()
    return drive(device, pressed)


if __name__ == "__main__":  # what Blender is in the tests that kill it
    device = HapticMaster(sys.argv[1])
    press(device)
    print(device.process.pid if device.process else 0, flush=True)
    drive(device, lambda _: False)
