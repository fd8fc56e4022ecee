"""A bench for Haply's Inverse3: its maker's service, as published, in front of emulated fingertips.

One message in, one state out; the first message lists the devices with their config. Written from docs.haply.co
(Inverse SDK, "WebSocket Protocol") and the types of the crate `haply`, apart from the client in core/device.
(A) While a client stands still the last force goes on; when its connection ends there is none.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import select
import socket
import time
from collections.abc import Iterator
from typing import Any, Final

from core.device import priority, wire
from core.vectors import ZERO, Vector, is_finite

from .faulty_emulator import TraceRow
from .hand import EmulatedHand
from .numbers import EmulatedSpec
from .tip import EmulatedTip

NAMES: Final = ("049D", "04A1", "04B7")
READY: Final = {"calibrated": True, "in_use": True, "power_supply": True, "ready": True, "started": True}


class HaplyService:
    """A service with up to three emulated devices.

    Args:
        number: of its port on this computer.
        spec: mass and friction of the fingertips.
        hand: what holds them.
        devices: how many there are.
        is_new: it speaks as version 3.5 does, else as 3.1.
        trace: a list to which each tick adds a row, see `FaultyEmulator`; the mode is always ARMED.

    Attributes:
        status: of all devices.
        messages: the last ones of the client.
        button: of a grip, pressed.
        is_stuck: it does not answer.
        gaps: from each state sent to the next message of the client [s].
        ends: it is to end.
    """

    def __init__(
        self, number: int, spec: EmulatedSpec, *, hand: EmulatedHand, devices: int = 3, is_new: bool = True,
        trace: list[TraceRow] | None = None,
    ) -> None:  # fmt: skip
        self._socket = socket.create_server(("127.0.0.1", number))
        self.number = self._socket.getsockname()[1]
        self.spec, self.hand, self.names, self.is_new, self.trace = spec, hand, NAMES[:devices], is_new, trace
        self.status = dict(READY)
        self.tips = [EmulatedTip(hand.target(i, 0.0)[0]) for i in range(devices)]
        self.forces: list[Vector] = [ZERO] * devices
        self.messages: list[str] = []
        self.gaps: list[float] = []
        self._stated = 0.0  # when the last state was sent [s]
        self.button = self.is_stuck = self.ends = False
        self._begun: float | None = None
        self._ticks = 0

    def serve(self, lifeline: int | None = None, seconds: float = float("inf")) -> None:
        """Serve one client after the other, until the lifeline closes or the time [s] is over."""
        end = time.perf_counter() + seconds
        with self._socket:
            while time.perf_counter() < end and not self.ends:
                if ended(lifeline):
                    return
                if self._begun:
                    self._run()
                if select.select([self._socket], [], [], 0.1)[0]:
                    client, _ = self._socket.accept()
                    with client:
                        if not self._talk(client, lifeline, end):
                            return
                    self.forces = [ZERO] * len(self.tips)

    def _talk(self, client: socket.socket, lifeline: int | None, end: float) -> bool:
        """Serve a client until it is gone; return False where the lifeline closed."""
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        head = b""
        while b"\r\n\r\n" not in head:
            more = client.recv(4096)
            if not more:
                return True
            head += more
        fields = dict(line.lower().partition(b":")[::2] for line in head.split(b"\r\n") if b":" in line)
        assert fields[b"upgrade"].strip() == b"websocket" and fields[b"sec-websocket-version"].strip() == b"13"
        key = head.partition(b"Sec-WebSocket-Key:")[2].partition(b"\r\n")[0].strip()
        client.sendall(self.welcome(key))
        client.sendall(framed(json.dumps(self._inventory())))
        rest = b""
        while time.perf_counter() < end and not self.ends:
            ready = select.select([client], [], [], 1e-3)[0]
            self._run()
            if ended(lifeline):
                return False
            if not ready or self.is_stuck:
                continue
            try:
                if not (data := client.recv(1 << 16)):
                    return True
                *messages, rest = [*unframed(rest + data)]
                for text in messages:
                    self.gaps += [time.perf_counter() - self._stated] if self._stated else []
                    self._obey(json.loads(text))
                    self.messages = [*self.messages[-9:], text]
                    client.sendall(framed(json.dumps(self._state())))
                    self._stated = time.perf_counter()
            except OSError:  # it is gone
                return True
        return False

    @staticmethod
    def welcome(key: bytes) -> bytes:
        """Return the answer to a client that greets with a key."""
        accept = base64.b64encode(hashlib.sha1(key + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest())
        return (
            b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n"
        )

    def _run(self) -> None:
        """Let hand and motors move the fingertips up to now; the trace has the time of a STATE, of 32 bits in us."""
        now = time.perf_counter()
        self._begun = self._begun or now
        while self._begun + self._ticks * self.spec.tick < now:
            at = self._begun + self._ticks * self.spec.tick
            self._ticks += 1
            if self.trace is not None:
                places, forces = [tip.position for tip in self.tips], [*self.forces]
                none = [ZERO] * (3 - len(self.tips))
                parts = (part for vector in (*places, *none, *forces, *none) for part in vector)
                self.trace.append((at * 1e6 % (1 << 32) * 1e-6, float(wire.ARMED), *parts))
            for i, tip in enumerate(self.tips):
                tip.step(self.spec, self.hand, i, at - self._begun, self.forces[i])

    def _obey(self, message: dict[str, Any]) -> None:
        for device in message.get("inverse3", ()):
            command = device["commands"]["set_cursor_force"]
            values = command["vector" if self.is_new else "values"]
            force = float(values["x"]), float(values["y"]), float(values["z"])
            assert is_finite(force)
            self.forces[self.names.index(device["device_id"])] = force

    def _inventory(self) -> dict[str, Any]:
        message = self._state()
        for device in message["inverse3"]:
            name = device["device_id"]
            device["config"] = {
                "type": "inverse3", "port": "COM12", "extended_device_id": name, "extended_firmware_version": "7.4",
                "device_info": {"major_version": 7, "minor_version": 4, "id": name, "device_type": 4, "uuid": name},
                "gravity_compensation": {"enabled": True, "scaling_factor": 1.0}, "handedness": "right",
                "streaming_mode": "USB", "torque_scaling": {"enabled": True},
            }  # fmt: skip
            device["config"] |= {"preset": "defaults", "basis": {"permutation": "XYZ"}} if self.is_new else {}
        return message

    def _state(self) -> dict[str, Any]:
        self._run()
        devices = [
            {
                "device_id": name,
                "state": {
                    "cursor_position": dict(zip("xyz", tip.position, strict=True)),
                    "cursor_velocity": dict(zip("xyz", tip.velocity, strict=True)),
                    "mode": "idle",
                    "control_mode": "force",
                    "current_cursor_force": dict(zip("xyz", force, strict=True)),
                },
                "status": self.status,
            }
            for name, tip, force in zip(self.names, self.tips, self.forces, strict=True)
        ]
        grip = {"device_id": "61576", "state": {"buttons": {"a": self.button, "b": False, "c": False}}}
        return {"session_id": 7, "inverse3": devices, "wireless_verse_grip": [grip]}


def ended(lifeline: int | None) -> bool:
    """Tell whether the other end of a pipe has closed."""
    return lifeline is not None and bool(select.select([lifeline], [], [], 0)[0]) and not os.read(lifeline, 4096)


def framed(text: str) -> bytes:
    """Return a text message of a server."""
    payload = text.encode()
    size = len(payload)
    head = bytes((0x81, size)) if size < 126 else bytes((0x81, 126)) + size.to_bytes(2, "big")
    return head + payload


def unframed(data: bytes) -> Iterator[Any]:
    """Yield the text messages of a client that are whole, then the bytes that are left."""
    while len(data) >= 2:
        size, at = data[1] & 0x7F, 2
        if size == 126:
            size, at = int.from_bytes(data[2:4], "big"), 4
        if len(data) < at + 4 + size:
            break
        assert data[0] == 0x81 and data[1] & 0x80, "a client sends whole text messages, masked"
        mask, payload = data[at : at + 4], data[at + 4 : at + 4 + size]
        yield bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload)).decode()
        data = data[at + 4 + size :]
    yield data


def run_service(service: HaplyService, lifeline: int | None, seconds: float) -> bool:
    """Run a service in a process of its own; return whether the system granted real-time priority."""
    granted = priority.request_priority()
    service.serve(lifeline, seconds)
    return granted
