"""The frames between a haptic device and its host, as bytes; PROTOCOL.md has the fields and their units.

A frame is a payload of at most 33 bytes, little-endian, and its CRC-32, coded by COBS so that 0x00 appears nowhere in
it, then 0x00. At this length CRC-32 detects every error of five bits or fewer. A reader that joins late or loses bytes
is synchronized again at the next 0x00.
COBS: each run of bytes up to a 0x00 is preceded by its length plus one, and the 0x00 is left out. Source:
Cheshire and Baker, Consistent Overhead Byte Stuffing.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from typing import Final, NamedTuple

PROTOCOL: Final = (2, 0)  # major: a difference is refused; minor: adds frame types, skipped if unknown
MOST_PAYLOAD: Final = 33  # [bytes] largest payload
FINGERS: Final = 3
PLACE_STEP: Final = 2e-5  # [m] unit of a position word: range 0.65 m to either side
LAST_PLACE: Final = 0x7FFF  # position word at which the range ends: the fingertip is there or farther away
FORCE_STEP: Final = 1e-3  # [N] unit of a force word: range 32 N
BAUD: Final = 921600  # [bit/s] rate of a serial line, enough for 2000 STATEs a second

ENABLE, DEADMAN, CLEAR = 1, 2, 4  # Command.flags
IDLE, ARMING, RAMP, ARMED, BRAKE, FAULT = range(6)  # DeviceState.status & MODE
MODE: Final = 7
LIMITED: Final = 8  # DeviceState.status: a limit reduces the force
MASKED: Final = 16  # DeviceState.status: MASKED << finger: its sensor is not trusted
# Fault.code and Disarm.reason
FAULT_NONE, FAULT_WATCHDOG, FAULT_SENSOR, FAULT_SPEED = range(4)
FAULT_ARM_REFUSED, FAULT_VERSION, FAULT_LINK, FAULT_HOST = range(4, 8)
DEADMAN_BUTTON: Final = 1  # DeviceState.buttons
EVERY_FINGER: Final = 255  # Fault.finger

Nine = tuple[int, ...]  # three words for each finger
NO_FORCE: Final[Nine] = (0,) * 9


class DeviceState(NamedTuple):
    """STATE, from the device at each tick: positions of the fingertips."""

    session: int
    seq: int
    ack: int
    t_us: int
    place: Nine
    buttons: int
    status: int


class Command(NamedTuple):
    """CMD, from the host in answer to each STATE: the forces."""

    session: int
    seq: int
    echo: int
    force: Nine
    flags: int
    ttl_ms: int


class Hello(NamedTuple):
    """HELLO, from the host: request a new session."""

    nonce: int
    major_min: int
    major_max: int


class Info(NamedTuple):
    """INFO, from the device, answers a HELLO of the same nonce: its specification, and the number of a new session."""

    nonce: int
    major: int
    minor: int
    session: int
    fingers: int
    tick_hz: int
    hold_ms: int
    zero_ms: int
    latch_ms: int
    peak_cn: int
    continuous_cn: int
    speed_dms: int
    viscous_cns_m: int


class Arm(NamedTuple):
    """ARM, from the host: request force."""

    session: int


class Disarm(NamedTuple):
    """DISARM, from the host: end all force."""

    session: int
    reason: int


class Fault(NamedTuple):
    """FAULT, from the device: sent at once, then every 100 ms while the fault is latched."""

    session: int
    code: int
    finger: int
    seq: int


Frame = DeviceState | Command | Hello | Info | Arm | Disarm | Fault

_TYPES: Final[dict[type, tuple[int, struct.Struct]]] = {
    DeviceState: (0x11, struct.Struct("<BBHHI9hBB")),
    Command: (0x12, struct.Struct("<BBHH9hBB")),
    Hello: (0x13, struct.Struct("<BHBB")),
    Info: (0x14, struct.Struct("<BHBBBBHBBBHHBH")),
    Arm: (0x15, struct.Struct("<BB")),
    Disarm: (0x16, struct.Struct("<BBB")),
    Fault: (0x18, struct.Struct("<BBBBH")),
}
_NESTED: Final = {DeviceState: (5, 14), Command: (4, 13)}  # range of numbers that form one field


def _maker(kind: type) -> Callable[[tuple[int, ...]], Frame]:
    """Return the function that makes a frame from the numbers of a payload, the first of which is its type."""
    make: Callable[[tuple[object, ...]], Frame] = kind._make  # type: ignore[attr-defined]
    if kind not in _NESTED:
        return lambda numbers: make(numbers[1:])
    first, last = _NESTED[kind]
    return lambda numbers: make((*numbers[1:first], numbers[first:last], *numbers[last:]))


_MAKERS: Final = {
    number: (layout.size + 4, layout.unpack_from, _maker(kind)) for kind, (number, layout) in _TYPES.items()
}
_CRC: Final = struct.Struct("<I")
_LONGEST: Final = MOST_PAYLOAD + 4 + 1  # [bytes] largest number between two 0x00: payload, CRC-32, one byte of COBS


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame on the line, including the closing 0x00.

    Raises:
        struct.error: a number does not fit its field.
    """
    number, layout = _TYPES[type(frame)]
    fields: list[int] = []
    for each in frame:
        fields.extend(each if isinstance(each, tuple) else (each,))
    payload = layout.pack(number, *fields)
    return stuff(payload + _CRC.pack(zlib.crc32(payload)))


def size(kind: type) -> int:
    """Return the size of a frame type on the line [bytes]."""
    return _TYPES[kind][1].size + 4 + 2


_CODES: Final = [bytes((n,)) for n in range(256)]


def stuff(block: bytes) -> bytes:
    """Return the COBS code of at most 253 bytes, with the closing 0x00."""
    return b"".join([_CODES[len(run) + 1] + run for run in block.split(b"\0")]) + b"\0"


def unstuff(code: bytes) -> bytes | None:
    """Return the decoded bytes of a COBS code without its closing 0x00, None if it is invalid."""
    runs, at, end = [], 0, len(code)
    while at < end:
        if not code[at]:
            return None
        after = at + code[at]
        runs.append(code[at + 1 : after])
        at = after
    return b"\0".join(runs) if at == end else None


class Decoder:
    """Find the frames in a stream of bytes, however it is cut; frames of an unknown type are skipped.

    refused: number of pieces between two 0x00 that were lost to errors on the line.
    """

    def __init__(self) -> None:
        self.refused = 0
        self._rest = b""

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames that end in the next bytes, oldest first."""
        pieces = (self._rest + data).split(b"\0")
        self._rest = pieces.pop()[: _LONGEST + 1]  # one byte too many is enough to refuse it at its end
        return [frame for piece in pieces if piece and (frame := self._frame(piece)) is not None]

    def _frame(self, piece: bytes) -> Frame | None:
        block = unstuff(piece) if len(piece) <= _LONGEST else None
        if block is None or len(block) < 5 or _CRC.unpack_from(block, len(block) - 4)[0] != zlib.crc32(block[:-4]):
            self.refused += 1
            return None
        maker = _MAKERS.get(block[0])
        if maker is None:
            return None
        length, unpack, make = maker
        if len(block) != length:
            self.refused += 1
            return None
        return make(unpack(block))


def seq_newer(seq: int, than: int) -> bool:
    """Return whether a 16-bit sequence number comes after another."""
    return 0 < (seq - than) & 0xFFFF < 0x8000
