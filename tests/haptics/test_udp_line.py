"""A device on the network, in a process that knows nothing of Dimple: armed, pressed, killed."""

import math
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.device import wire
from core.device.device import Device
from core.device.force_guard import Arming
from core.device.orders import LinkState, ServoReport
from core.device.seal import Seal
from core.device.udp_line import open_udp
from tests.haptics.bench_device import wall
from tests.haptics.machine import unable

PATIENCE = 20.0  # [s]
SECRET = "a secret of this test alone"


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
    made = Network(f"udp:127.0.0.1:{number}", trace, start(number, trace))
    yield made
    made.process.kill()
    made.process.wait()


def start(number: int, trace: Path) -> subprocess.Popen[bytes]:
    """Start a device at a port."""
    words = [sys.executable, "-I", "-S", str(Path(__file__).with_name("network_device.py"))]
    process = subprocess.Popen([*words, str(number), str(trace), SECRET], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout and process.stdout.readline() == b"ready\n"
    return process


def drive(device: Device, until: Callable[[ServoReport], bool], *, held: bool = True) -> ServoReport:
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
    device = Device(network.port, secret=SECRET)
    device.open()
    drive(device, lambda report: report.arming is Arming.ON and max(map(abs, report.tips[0].force)) > 0.5)
    assert device.process
    device.process.kill()
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.arming is Arming.OFF
    device.close()
    time.sleep(0.2)
    time_s, mode, force, _ = network.rows().T
    assert force.max() > 0 and mode.max() == 5 and force[-100:].max() == 0
    last = time_s[np.flatnonzero(force)[-1]]
    assert time_s[mode == 5][0] - last > 0.05, "zero well before the fault is latched"


def test_without_the_key_a_device_on_the_network_never_gets_force(network: Network) -> None:
    device = Device(network.port, secret=SECRET)
    device.open()
    begun = time.perf_counter()
    drive(device, lambda report: report.states > 300 and time.perf_counter() - begun > 1.0, held=False)
    device.close()
    _, mode, force, _ = network.rows().T
    assert force.max() == 0 and not np.isin(mode, (2, 3)).any()


def test_a_device_that_leaves_the_network_is_lost_and_found_again_unarmed_when_it_starts(network: Network) -> None:
    device = Device(network.port, secret=SECRET)
    device.open()
    drive(device, lambda report: report.arming is Arming.ON)
    network.process.kill()
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.arming is Arming.OFF and "silent" in report.note
    network.process.wait()
    network.process = start(int(network.port.rpartition(":")[2]), network.trace)
    assert drive(device, lambda report: report.link is LinkState.READY, held=False).arming is not Arming.ON
    drive(device, lambda report: report.arming is Arming.ON)
    device.close()


@pytest.mark.parametrize("path", ["udp:", "udp:host", "udp:127.0.0.1:0", "udp:127.0.0.1:70000", "udp:127.0.0.1:x"])
def test_what_is_no_address_is_refused_in_words(path: str) -> None:
    with pytest.raises(DimpleError, match="udp:127.0.0.1:7400"):
        open_udp(path, SECRET)


@pytest.mark.parametrize("path", ["udp:192.0.2.1:7400", "udp:0.0.0.0:7400", "udp:[2001:db8::1]:7400"])
def test_another_computer_is_reached_only_where_that_is_allowed(path: str) -> None:
    with pytest.raises(DimpleError, match="another computer"):
        open_udp(path, SECRET)


def test_a_device_on_the_network_needs_a_secret() -> None:
    with pytest.raises(DimpleError, match="secret"):
        open_udp("udp:127.0.0.1:7400", "short")


def test_both_usual_forms_of_an_address_are_understood() -> None:
    for path in ("udp:127.0.0.1:7400", "udp:localhost:7400", "udp:[::1]:7400", "udp:::1:7400"):
        open_udp(path, SECRET).close()


class Relay:
    """It stands between host and device, keeps all datagrams, and sends to either from the other's address."""

    def __init__(self, device: int) -> None:
        self.to_host, self.to_device = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self.to_host.bind(("127.0.0.1", 0))
        self.to_device.connect(("127.0.0.1", device))
        self.port, self.host = self.to_host.getsockname()[1], ("127.0.0.1", 0)
        self.from_host: list[bytes] = []
        self.from_device: list[bytes] = []
        self._ends = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._ends:
            for ready in select.select([self.to_host, self.to_device], [], [], 0.1)[0]:
                if ready is self.to_host:
                    data, self.host = ready.recvfrom(2048)
                    self.from_host.append(data)
                    self.to_device.send(data)
                else:
                    self.from_device.append(data := ready.recv(2048))
                    self.to_host.sendto(data, self.host)

    def close(self) -> None:
        self._ends = True
        self._thread.join()
        self.to_host.close()
        self.to_device.close()


def attacks(relay: Relay) -> list[tuple[str, list[bytes], list[bytes]]]:
    """Return names, what is sent to the device, and what to the host: of all sessions, in the old form and sealed."""
    full, held = (0x7FFF,) * 9, wire.ENABLE | wire.DEADMAN
    to_device, to_host = [wire.encode(wire.Hello(9, *wire.PROTOCOL[:1] * 2))], []
    for session in range(256):
        to_device += [wire.encode(wire.Arm(session)), wire.encode(wire.Disarm(session, 0))]
        to_device += [wire.encode(wire.Command(session, seq, seq, full, held, 5)) for seq in (0, 0x4000, 0x8000)]
        away = (0x2000,) * 9
        to_host += [wire.encode(wire.Fault(session, wire.FAULT_SPEED, 255, 0))]
        to_host += [wire.encode(wire.DeviceState(session, seq, 0, 0, away, 1, wire.ARMED)) for seq in (0, 0x8000)]
    stranger = Seal("the secret of another")
    stranger.other = relay.from_device[-1][8:16]  # the numbers are no secret
    to_host_stranger = Seal("the secret of another")
    to_host_stranger.other = relay.from_host[-1][8:16]
    return [
        ("without a seal", to_device, to_host),
        ("under another secret", [stranger.close(x) for x in to_device], [to_host_stranger.close(x) for x in to_host]),
        ("a greeting of another host that knows the secret", [Seal(SECRET).close(to_device[0])], []),
        ("all that was ever sent, again", list(relay.from_host), list(relay.from_device)),
        ("what one end sent, back to it", list(relay.from_device), list(relay.from_host)),
        ("a higher count", *([ahead(x) for x in sent[-500:]] for sent in (relay.from_host, relay.from_device))),
    ]


def ahead(datagram: bytes) -> bytes:
    """Return a datagram with a higher count than any, which its seal does not cover."""
    return datagram[:16] + (int.from_bytes(datagram[16:24], "little") + 100_000).to_bytes(8, "little") + datagram[24:]


def test_nobody_who_lacks_the_secret_moves_the_hand_or_ends_the_touch(network: Network) -> None:
    """From another socket, and from the very addresses of host and device."""
    number = int(network.port.rpartition(":")[2])
    relay, other = Relay(number), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    device = Device(f"udp:127.0.0.1:{relay.port}", secret=SECRET)
    device.open()
    pressed = drive(device, lambda r: r.arming is Arming.ON and max(map(abs, r.tips[0].force)) > 0.5)
    x, y, z = pressed.tips[0].position

    def press() -> ServoReport:
        """Go on pressing, as Blender does."""
        now = time.perf_counter()
        device.hold(math.inf)
        device.write([replace(wall(now, k=300.0), place=(x, y, z + 0.005)), None, None])
        time.sleep(2e-3)
        return device.read()

    begun = time.perf_counter()
    for name, to_device, to_host in attacks(relay):
        before = device.read()
        for i in range(max(len(to_device), len(to_host))):
            if i < len(to_device):
                relay.to_device.send(to_device[i]) if i % 2 else other.sendto(to_device[i], ("127.0.0.1", number))
            if i < len(to_host):
                (relay.to_host if i % 2 else other).sendto(to_host[i], relay.host)
            if i % 20 == 0:
                press()
        while (after := press()).states < before.states + 100 and after.link is LinkState.READY:
            pass
        assert after.link is LinkState.READY and after.arming is Arming.ON, name
        for tip, at in zip(after.tips, pressed.tips, strict=True):
            assert max(abs(a - b) for a, b in zip(tip.position, at.position, strict=True)) < 1e-3, name
    ended = time.perf_counter()
    device.close()
    relay.close()
    other.close()
    time_s, mode, force, session = network.rows().T
    attacked = (time_s > begun) & (time_s < ended)
    assert np.isin(mode[attacked], (2, 3)).all() and len(set(session[attacked])) == 1
    assert force[attacked].max() < 2000, "the force is the host's alone, 1.5 N"
