"""A device on the network, in a process that knows nothing of Dimple: armed, pressed, killed."""

import math
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.device.device import HapticMaster
from core.device.force_guard import Arming
from core.device.orders import LinkState, ServoReport
from core.device.spec import geometry_crc
from core.device.udp_line import open_udp
from tests.haptics.bench_device import wall
from tests.haptics.host import SPEC
from tests.haptics.machine import unable

PATIENCE = 20.0  # [s]


@dataclass
class Network:
    port: str
    trace: Path
    process: subprocess.Popen[bytes]

    def rows(self) -> np.ndarray:
        assert self.process.stdin
        self.process.stdin.close()
        self.process.wait(10)
        return np.loadtxt(self.trace, delimiter=",")


@pytest.fixture
def network(tmp_path: Path) -> Iterator[Network]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    trace = tmp_path / "trace.csv"
    words = [sys.executable, "-I", "-S", str(Path(__file__).with_name("network_device.py"))]
    process = subprocess.Popen(
        [*words, str(number), str(geometry_crc(SPEC)), str(trace)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdout and process.stdout.readline() == b"ready\n"
    yield Network(f"udp:127.0.0.1:{number}", trace, process)
    process.kill()
    process.wait()


def drive(device: HapticMaster, until: Callable[[ServoReport], bool], *, held: bool = True) -> ServoReport:
    """Ask for force, press as soon as there is some, until something holds.

    The wall stays where it is put: one that followed the converters' noise would give energy, and be let go.
    """
    asked, begun, top = -math.inf, time.perf_counter(), None
    while time.perf_counter() - begun < PATIENCE:
        if until(report := device.read()):
            return report
        now = time.perf_counter()
        device.hold(math.inf if held else 0.0)
        if report.arming is Arming.OFF and now - asked > 0.5:
            asked = now
            device.arm()
        if top is None and report.arming in (Arming.RAMP, Arming.ON):
            top = (*report.tips[0].position[:2], report.tips[0].position[2] + 0.005)
        device.write([replace(wall(now, k=300.0), place=top) if top else None, None, None])
        time.sleep(1 / 60)
    unable(f"this machine cannot run a loop of 1 kHz: {report}")


def test_a_device_of_somebody_elses_is_armed_pressed_and_lets_go_when_the_host_is_killed(network: Network) -> None:
    device = HapticMaster(network.port)
    device.open()
    drive(device, lambda report: report.arming is Arming.ON and max(map(abs, report.tips[0].force)) > 0.5)
    assert device.process
    device.process.kill()
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.arming is Arming.OFF
    device.close()
    time.sleep(0.2)
    time_s, mode, torque = network.rows().T
    assert torque.max() > 0 and mode.max() == 5 and torque[-100:].max() == 0
    last = time_s[np.flatnonzero(torque)[-1]]
    assert time_s[mode == 5][0] - last > 0.05, "zero well before the fault is latched"


def test_without_the_key_a_device_on_the_network_never_gets_force(network: Network) -> None:
    device = HapticMaster(network.port)
    device.open()
    begun = time.perf_counter()
    drive(device, lambda report: report.states > 300 and time.perf_counter() - begun > 1.0, held=False)
    device.close()
    _, mode, torque = network.rows().T
    assert torque.max() == 0 and not np.isin(mode, (2, 3)).any()


def test_a_device_that_leaves_the_network_is_lost_and_blender_hears_of_it(network: Network) -> None:
    device = HapticMaster(network.port)
    device.open()
    drive(device, lambda report: report.arming is Arming.ON)
    network.process.kill()
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.arming is Arming.OFF and "silent" in report.note
    device.close()


@pytest.mark.parametrize("path", ["udp:", "udp:host", "udp:127.0.0.1:0", "udp:127.0.0.1:70000", "udp:127.0.0.1:x"])
def test_what_is_no_address_is_refused_in_words(path: str) -> None:
    with pytest.raises(DimpleError, match="udp:127.0.0.1:7400"):
        open_udp(path)
