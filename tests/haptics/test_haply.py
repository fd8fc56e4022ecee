"""An Inverse3 through the service of its maker: the one of the test bench, and the servo in its own process."""

import json
import math
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from core.device.device import Device
from core.device.force_guard import Arming
from core.device.orders import LinkState, ServoReport
from core.device.web_socket import WebSocket
from core.errors import DimpleError
from studies.bench.hand import EmulatedHand
from studies.bench.haply_service import HaplyService, framed, unframed
from studies.bench.numbers import load_emulated
from tests.haptics.bench_device import wall
from tests.haptics.machine import unable

AT = ((0.05, -0.12, 0.15), (-0.03, 0.02, 0.11), (0.0, 0.1, 0.15))  # [m] of the fingertips, right, forward, up
PATIENCE = 20.0  # [s]
DEEP, K = 0.005, 300.0  # [m], [N/m] of the wall under the first fingertip


@pytest.fixture
def serve() -> Iterator[Callable[..., HaplyService]]:
    """Return a function that starts a service; all end with the test."""
    running: list[tuple[HaplyService, threading.Thread]] = []

    def start(**how: object) -> HaplyService:
        hand = EmulatedHand(tips=tuple(((0.0, *at),) for at in AT), stiffness=2e4, damping=50.0)
        service = HaplyService(0, load_emulated(), hand=hand, trace=[], **how)  # type: ignore[arg-type]
        thread = threading.Thread(target=service.serve, kwargs={"seconds": 60.0}, daemon=True)
        thread.start()
        running.append((service, thread))
        return service

    yield start
    for service, _ in running:
        service.ends = True
    for _, thread in running:
        thread.join()


def drive(device: Device, until: Callable[[ServoReport], bool], *, held: bool = True) -> ServoReport:
    """Ask for force, press the first fingertip as soon as there is some, until something holds."""
    asked, begun, place = -math.inf, time.perf_counter(), (*AT[0][:2], AT[0][2] + DEEP)
    while time.perf_counter() - begun < PATIENCE:
        if until(report := device.read()):
            return report
        now = time.perf_counter()
        device.hold(math.inf if held else 0.0)
        if report.arming is Arming.OFF and now - asked > 0.5:
            asked = now
            device.arm()
        on = report.arming in (Arming.RAMP, Arming.ON)
        device.write([replace(wall(now, k=K), place=place) if on else None, None, None])
        time.sleep(1 / 60)
    unable(f"this machine cannot run a loop of 1 kHz: {report}")


@pytest.mark.parametrize(("devices", "is_new"), [(1, True), (3, True), (1, False)])
def test_an_inverse3_is_armed_and_feels_the_law_in_newtons_and_metres(
    serve: Callable[..., HaplyService], devices: int, is_new: bool
) -> None:
    """Services before 3.5 name the force otherwise. The axes are Blender's: up is z."""
    service = serve(devices=devices, is_new=is_new)
    device = Device(f"haply:{service.number}")
    device.open()
    drive(device, lambda report: report.arming is Arming.ON)

    def is_law(_: ServoReport) -> bool:
        depth = AT[0][2] + DEEP - service.tips[0].position[2]
        return DEEP > depth > 0.95 * DEEP and abs(service.forces[0][2] - K * depth) < 0.02

    report = drive(device, is_law)
    assert len(report.tips) == devices
    for tip, at in zip(report.tips, AT, strict=False):
        assert tip.position == pytest.approx(at, abs=2e-3)
    assert service.forces[0][:2] == (0.0, 0.0)
    assert all(force == (0.0, 0.0, 0.0) for force in service.forces[1:])
    device.close()
    end(service)


def end(service: HaplyService) -> None:
    """Wait until no force is left."""
    until = time.perf_counter() + PATIENCE
    while any(map(any, service.forces)):
        assert time.perf_counter() < until, "a force goes on without a client"
        time.sleep(0.01)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_servo_that_is_killed_or_hangs_leaves_no_force(
    serve: Callable[..., HaplyService], how: signal.Signals
) -> None:
    """Blender ends one that hangs: the service holds the last force for as long as its client is connected."""
    service = serve(devices=1)
    device = Device(f"haply:{service.number}")
    device.open()
    drive(device, lambda report: report.tips and report.tips[0].force[2] > 0.5)
    assert device.process
    device.process.send_signal(how)
    assert drive(device, lambda report: report.link is LinkState.LOST).arming is Arming.OFF
    end(service)
    device.close()


def test_without_the_key_there_is_never_a_force_and_the_button_of_a_grip_is_a_key(
    serve: Callable[..., HaplyService],
) -> None:
    service = serve(devices=1)
    device = Device(f"haply:{service.number}")
    device.open()
    begun = time.perf_counter()
    drive(device, lambda report: report.states > 300 and time.perf_counter() - begun > 1.0, held=False)
    assert service.trace is not None and not any(any(row[11:]) for row in service.trace)
    service.button = True
    drive(device, lambda report: report.tips[0].force[2] > 0.5, held=False)
    device.close()


def test_a_service_that_stands_still_is_lost_and_one_that_ends_too(serve: Callable[..., HaplyService]) -> None:
    service = serve(devices=1)
    device = Device(f"haply:{service.number}")
    device.open()
    drive(device, lambda report: report.arming is Arming.ON)
    service.is_stuck = True
    report = drive(device, lambda report: report.link is LinkState.LOST)
    assert report.arming is Arming.OFF and "silent" in report.note
    service.is_stuck = False
    drive(device, lambda report: report.link is LinkState.READY and report.arming is Arming.ON)
    service.ends = True
    assert "lost" in drive(device, lambda report: report.link is LinkState.LOST).note
    device.close()


def test_a_second_blender_is_refused_and_takes_over_once_the_first_has_ended(
    serve: Callable[..., HaplyService],
) -> None:
    """The service takes forces from all its clients; those of two would alternate on the hand."""
    service = serve(devices=1)
    first, second = Device(f"haply:{service.number}"), Device(f"haply:{service.number}")
    first.open()
    drive(first, lambda report: report.states > 10, held=False)
    second.open()
    report = drive(second, lambda report: report.link is LinkState.REFUSED, held=False)
    assert "another Blender" in report.note and drive(first, lambda _: True).link is LinkState.READY
    first.close()
    second.open()
    drive(second, lambda report: report.states > 10, held=False)
    second.close()


def test_a_device_that_is_not_ready_is_not_trusted(serve: Callable[..., HaplyService]) -> None:
    service = serve(devices=2)
    service.status["calibrated"] = False
    device = Device(f"haply:{service.number}")
    device.open()
    report = drive(device, lambda report: report.states > 50, held=False)
    assert [tip.masked for tip in report.tips] == [True, True]
    device.close()


def test_what_is_no_service_is_refused_in_words(serve: Callable[..., HaplyService]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        nobody = free.getsockname()[1]
    none = serve(devices=0)
    for port, words in (
        (f"haply:{nobody}", "Start Haply Hub"),
        (f"haply:{none.number}", "sees no Inverse3"),
        ("haply:", "haply:10001"),
        ("haply:x", "haply:10001"),
    ):
        device = Device(port)
        device.open()
        assert words in drive(device, lambda report: report.link is LinkState.REFUSED, held=False).note
        device.close()


class Peer:
    """The other end of a WebSocket, by hand."""

    def __init__(self, answer: bytes | None = None) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.number, self._answer = self._server.getsockname()[1], answer
        self._thread = threading.Thread(target=self._greet, daemon=True)
        self._thread.start()

    def _greet(self) -> None:
        self.socket = self._server.accept()[0]
        key = self.socket.recv(4096).partition(b"Sec-WebSocket-Key: ")[2].partition(b"\r\n")[0]
        self.socket.sendall(self._answer or HaplyService.welcome(key))

    def open(self) -> WebSocket:
        made = WebSocket(self.number)
        self._thread.join()
        return made


def read(made: WebSocket, n: int) -> list[str]:
    """Return the next messages."""
    found: list[str] = []
    until = time.perf_counter() + PATIENCE
    while len(found) < n and time.perf_counter() < until:
        found += made.read()
    return found


def test_messages_come_whole_however_they_are_cut() -> None:
    peer = Peer()
    made = peer.open()
    texts = ["", "short", "x" * 126, "ä" * 40_000]
    stream = b"".join(framed(text) if len(text) < 60_000 else b"" for text in texts[:3])
    big = texts[3].encode()
    stream += b"\x01\x7f" + (30_000).to_bytes(8, "big") + big[:30_000]  # in parts, with a ping between them
    stream += b"\x89\x02hi" + b"\x80\x7f" + (len(big) - 30_000).to_bytes(8, "big") + big[30_000:]
    for at in range(0, len(stream), 977):
        peer.socket.sendall(stream[at : at + 977])
    assert read(made, 4) == texts
    assert peer.socket.recv(100)[:2] == b"\x8a\x82", "a ping is answered"
    assert made.write(json.dumps(["a"] * 100))
    assert [*unframed(peer.socket.recv(4096))][0] == json.dumps(["a"] * 100)


@pytest.mark.parametrize("bad", [b"\x88\x00", b"\x81\x7f" + (1 << 40).to_bytes(8, "big")])
def test_a_close_and_an_endless_message_end_the_connection(bad: bytes) -> None:
    peer = Peer()
    made = peer.open()
    peer.socket.sendall(bad)
    with pytest.raises(ConnectionResetError):
        read(made, 1)


@pytest.mark.parametrize("answer", [b"HTTP/1.1 200 OK\r\n\r\n", b"SSH-2.0-x\r\n\r\n", HaplyService.welcome(b"another")])
def test_what_is_no_web_socket_is_refused(answer: bytes) -> None:
    with pytest.raises(DimpleError, match="not the port of a device service"):
        Peer(answer).open()
