"""The servo as a process of its own: a serial line, a mailbox, a lifeline, and `Servo.step` between them.

Its standard input is the lifeline: when Blender ends, however it does, the pipe closes. The device is then disarmed,
and the process ends with it.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, Protocol

from ..errors import DimpleError
from . import scheduling
from .byte_poller import Poller
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .serial_link import WINDOWS, LineLost, SerialLine, open_line
from .servo import Servo
from .servo_messages import ORDER_SIZE, LinkState, ServoReport, pack_report, unpack_order
from .spec import Spec, load_spec
from .udp_line import PREFIX, UdpLine, open_udp

POLL_TIME: Final = 0.001  # [s] at most between two looks at line and lifeline: something comes each tick anyway
REPORT_EVERY: Final = 0.002  # [s] the most that a report adds to the age of the positions a session is given
FLUSH_TIME: Final = 0.010  # [s] for the bytes of the last command to leave
BLENDER_GONE: Final = 10.0  # [s] without an order, where a pipe cannot be watched (Windows)


class MakeServo(Protocol):
    """What makes a servo for a device; a study passes one that keeps a log."""

    def __call__(self, spec: Spec, *, nonce: int) -> Servo:
        """Return a servo."""


def run(make_servo: MakeServo, port: str, mailbox: Path, device: Path | None) -> int:
    """Serve a line until standard input closes, and leave the device without force.

    Args:
        make_servo: the class Servo.
        port: path of the serial port.
        mailbox: the file that Blender made.
        device: device file, None for the Haptic Master's.

    Returns:
        The exit code: 0, or 2 where the line was refused or lost; the reason is in the last report.
    """
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    scheduling.request_priority()
    scheduling.keep_processors_awake()
    gc.disable()  # nothing here is in a cycle, and a collection would be late for a tick
    box, servo = Mailbox(mailbox), None
    try:
        spec = load_spec(device)
        servo, line = make_servo(spec, nonce=os.getpid() & 0xFFFF), open_to(port, spec.baud)
        try:
            serve(servo, line, box, listener(line))
        finally:
            release(servo, line)
        return 0 if servo.link is not LinkState.REFUSED else 2
    except DimpleError as error:
        link = LinkState.LOST if isinstance(error, LineLost) else LinkState.REFUSED
        report = replace(servo.report() if servo else ServoReport(), link=link, note=str(error))
        box.post(FROM_SERVO, pack_report(report))
        return 2
    finally:
        box.close()


def serve(servo: Servo, line: SerialLine | UdpLine, box: Mailbox, listen: Callable[[float], bytes | None]) -> None:
    """Answer the device until Blender is gone or the device refused.

    Args:
        servo: what answers.
        line: to the device.
        box: shared with Blender.
        listen: see `listener`.

    Raises:
        LineLost: the line is gone.
    """
    seen, posted, ordered = 0, 0.0, time.perf_counter()
    while (data := listen(ordered)) is not None:
        now = time.perf_counter()
        out = servo.step(now, data)
        if out:
            servo.unsent += not line.write(out)
        if now - posted > REPORT_EVERY or servo.link is LinkState.REFUSED:
            posted = now
            box.post(FROM_SERVO, pack_report(servo.report()))
        if servo.link is LinkState.REFUSED:
            return
        seen, message = box.read(TO_SERVO, ORDER_SIZE, seen)  # after the answer: no device waits for Blender
        if message:
            ordered = time.perf_counter()
            servo.order = unpack_order(message)


def open_to(port: str, baud: int) -> SerialLine | UdpLine:
    """Open the line that a port names: a serial port, or an address on the network."""
    return open_udp(port) if port.startswith(PREFIX) else open_line(port, baud)


def listener(line: SerialLine | UdpLine) -> Callable[[float], bytes | None]:
    """Return a function that waits for the next bytes of the line, given when the last order came [s].

    The function returns b"" where no bytes came, and None where Blender is gone.
    """
    if WINDOWS:

        def by_orders(ordered: float) -> bytes | None:
            line.wait(POLL_TIME)
            return line.read() if time.perf_counter() - ordered < BLENDER_GONE else None

        return by_orders

    stdin, port = sys.stdin.fileno(), line.fileno()
    poller = Poller(port, stdin)

    def by_pipe(_ordered: float) -> bytes | None:
        ready = poller.wait(POLL_TIME)
        if stdin in ready and not os.read(stdin, 4096):
            return None
        return line.read() if port in ready else b""

    return by_pipe


def release(servo: Servo, line: SerialLine | UdpLine) -> None:
    """Disarm the device, if it can still be reached, and free the port."""
    try:
        line.write(servo.close())
        time.sleep(FLUSH_TIME)
    except LineLost:
        pass
    line.close()
