"""A line to Haply's Inverse3 through its maker's service on this computer: frames to the servo, JSON to the service.

Each message to the service sets the force of up to three devices; the answer contains their positions. Units are metres
and newtons; x points right, y forward, z up, as in Blender. Service 3.1 or later.
Sources: docs.haply.co, Inverse SDK, "WebSocket Protocol" and "Basis Permutation"; the types of the crate `haply` 1.3.
(A) marks assumptions: the limits and the friction of the device are not published there, nor what the service does with
the last force while a client hangs; when a client ends, so does its connection.
"""

from __future__ import annotations

import json
import math
import os
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import IO, Any, Final

from ..errors import DimpleError
from ..file_lock import lock
from . import wire
from .serial_line import LineLost
from .spec import Spec
from .udp_line import SocketLine
from .web_socket import WebSocket

PREFIX: Final = "haply:"
EXAMPLE: Final = "haply:10001"
INVERSE3: Final = Spec(peak_force=8.0, continuous_force=3.0, viscous=2.0)  # (A)
_HELD: Final = wire.ENABLE | wire.DEADMAN


class HaplyLine(SocketLine):
    """A connection to the service that answers the servo as a device of the protocol does.

    The service sends nothing unasked, so each command requests the next positions: one tick apart.
    It takes forces from all its clients, and those of two would alternate on the hand: a locked file keeps a second one
    of ours away while `claim` is open.
    """

    def __init__(self, service: WebSocket, name: str, claim: IO[bytes]) -> None:
        super().__init__(service.socket, name)
        self._service, self._claim = service, claim
        self._decoder = wire.Decoder()
        self._devices: list[str] = []  # their ids, in the order of the service
        self._is_new = False  # service 3.5 or later, which renamed a field
        self._hello: wire.Hello | None = None
        self._session = self._states = self._ack = 0
        self._mode, self._asked = wire.IDLE, 0.0  # when the last message left [s]
        self._forces: wire.Nine = wire.NO_FORCE

    def read(self) -> bytes:
        """Return the frames that the newest message is converted to, b"" if none has arrived."""
        try:
            messages = self._service.read()
        except OSError as error:
            raise self._gone(error) from None
        try:
            return self._take(json.loads(messages[-1])) if messages else b""
        except DimpleError:
            raise
        except (ArithmeticError, AttributeError, KeyError, TypeError, ValueError) as error:
            raise LineLost("The Haply service sent data that Dimple cannot read: {error}.", error=repr(error)) from None

    def write(self, data: bytes) -> bool:
        """Take the frames of the servo and set the forces; return False if these could not be sent."""
        ask = False
        for frame in self._decoder.feed(data):
            if isinstance(frame, wire.Hello):
                self._hello, self._mode, self._forces, ask = frame, wire.IDLE, wire.NO_FORCE, True
            elif isinstance(frame, wire.Command):
                held = frame.flags & _HELD == _HELD and self._mode == wire.ARMED
                self._ack, self._forces, ask = frame.seq, frame.force if held else wire.NO_FORCE, True
            elif isinstance(frame, wire.Arm):
                self._mode = wire.ARMED  # the servo ramps the force
            elif isinstance(frame, wire.Disarm):
                self._mode, self._forces, ask = wire.IDLE, wire.NO_FORCE, True
        return self._ask() if ask and self._devices else True

    def _ask(self) -> bool:
        """Set the forces, which also requests the positions."""
        time.sleep(max(self._asked + INVERSE3.tick - time.perf_counter(), 0.0))
        self._asked = time.perf_counter()
        field, force = "vector" if self._is_new else "values", [part * wire.FORCE_STEP for part in self._forces]
        devices = []
        for i, each in enumerate(self._devices):
            command = {field: dict(zip("xyz", force[3 * i : 3 * i + 3], strict=True))}
            devices.append({"device_id": each, "commands": {"set_cursor_force": command}})
        try:
            return self._service.write(json.dumps({"inverse3": devices}))
        except OSError as error:
            raise self._gone(error) from None

    def _take(self, message: dict[str, Any]) -> bytes:
        """Return the frames of a message: the first message names the devices, and each has their positions."""
        devices = {device["device_id"]: device for device in message.get("inverse3", ())}
        if not self._devices:
            if not devices:
                raise DimpleError("The Haply service sees no Inverse3. Connect once Haply Hub shows the device.")
            self._devices = list(devices)[: wire.FINGERS]
            self._is_new = "preset" in devices[self._devices[0]].get("config", {})
            self._ask()
        out, hello, self._hello = b"", self._hello, None
        if hello:
            self._session = self._session % 255 + 1
            out = wire.encode(replace(INVERSE3, fingers=len(self._devices)).info(hello.nonce, self._session))
        return out + wire.encode(self._state(message, devices))

    def _state(self, message: dict[str, Any], devices: dict[str, Any]) -> wire.DeviceState:
        self._states += 1
        words, status = [], self._mode
        for i, each in enumerate(self._devices):
            device = devices.get(each, {})
            at = device.get("state", {}).get("cursor_position", {})
            place = [float(at.get(axis, math.nan)) for axis in "xyz"]
            trusted = all(device.get("status", {}).get(name, True) for name in ("ready", "calibrated", "power_supply"))
            trusted &= all(abs(part) < wire.LAST_PLACE * wire.PLACE_STEP for part in place)
            words += [round(part / wire.PLACE_STEP) if trusted else 0 for part in place]
            status |= 0 if trusted else wire.MASKED << i
        grips = (*message.get("wireless_verse_grip", ()), *message.get("custom_verse_grip", ()))
        pressed = any(grip.get("state", {}).get("buttons", {}).get("a") for grip in grips)
        return wire.DeviceState(
            self._session, self._states & 0xFFFF, self._ack, round(1e6 * time.perf_counter()) & 0xFFFFFFFF,
            (*words, *wire.NO_FORCE[len(words) :]), wire.DEADMAN_BUTTON * pressed, status,
        )  # fmt: skip


def open_haply(path: str) -> HaplyLine:
    """Open a connection to the service at "haply:PORT" of this computer.

    Raises:
        DimpleError: the port is invalid, or no service answers there.
    """
    number = path.removeprefix(PREFIX)
    if not number.isdecimal() or not 0 < int(number) < 0x10000:
        raise DimpleError("{path} is not a port of a Haply service. Write it as {example}.", path=path, example=EXAMPLE)
    claim = Path(tempfile.gettempdir()) / f"dimple-haply-{int(number)}-{getattr(os, 'getuid', int)()}.lock"
    try:
        held = claim.open("ab")
        lock(held)
    except OSError:
        raise DimpleError(
            "{path} is in use by another program, or another Blender. Close that one, then connect again.", path=path
        ) from None
    try:
        return HaplyLine(WebSocket(int(number)), path, held)
    except OSError as error:
        raise DimpleError(
            "No Haply service answers at {path} ({error}). Start Haply Hub, or the Inverse Service 3.1 or later.",
            path=path, error=error.strerror or error
        ) from None  # fmt: skip
