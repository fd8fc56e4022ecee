"""The servo as a process of its own: a line, a mailbox, a lifeline, and `Servo.step` between them.

Its standard input is the lifeline: when Blender ends, however it does, the pipe closes; the device is then told to
let go, and the process ends with it.
"""

from __future__ import annotations

import argparse
import gc
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ..errors import DimpleError
from . import scheduling
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .messages import ORDER_SIZE, Link, Report, pack_report, unpack_order
from .poller import Arrivals
from .serial_link import WINDOWS, LinkLost, open_link
from .serial_link import Link as Line
from .servo import Servo
from .spec import load_spec

LogRow = tuple[float, ...]

LOOK = 0.001  # [s] at most between two looks at line and lifeline: what comes each tick is not waited for any longer
REPORT_EVERY = 0.002  # [s] the most that a report adds to the age of the places a session is given
LAST_WORDS = 0.010  # [s] for the bytes of the last command to leave
BLENDER_GONE = 10.0  # [s] without an order where a pipe cannot be watched (Windows)


def run(options: argparse.Namespace) -> int:
    """Serve a line until standard input closes, and leave it without force; return 0, or 2 with the reason posted."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    scheduling.ask()
    gc.disable()  # nothing here is in a cycle, and a collection would be late for a tick
    box, servo = Mailbox(options.mailbox), None
    log: list[LogRow] | None = [] if options.log else None
    try:
        spec = load_spec(options.device)
        spec = replace(spec, baud=options.baud or spec.baud)
        servo, line = Servo(spec, nonce=os.getpid() & 0xFFFF), open_link(options.port, spec.baud)
        try:
            serve(servo, line, box, listener(line), log)
        finally:
            hang_up(servo, line)
            write_log(options.log, log)
        return 0 if servo.link is not Link.REFUSED else 2
    except DimpleError as error:
        link = Link.LOST if isinstance(error, LinkLost) else Link.REFUSED
        report = replace(servo.report() if servo else Report(), link=link, message=str(error))
        box.post(FROM_SERVO, pack_report(report))
        return 2
    finally:
        box.close()


def serve(
    servo: Servo, line: Line, box: Mailbox, listen: Callable[[float], bytes | None], log: list[LogRow] | None = None
) -> None:
    """Answer the device until Blender is gone or the device refused; log each answer where asked to.

    Raises:
        LinkLost: the line is gone.
    """
    seen, posted, heard = 0, 0.0, time.perf_counter()
    while (data := listen(heard)) is not None:
        now = time.perf_counter()
        out = servo.step(now, data)
        if out:
            servo.unsent += not line.write(out)
            if log is not None and servo.device_time_us >= 0:
                log.append((servo.device_time_us, *(c for tip in servo.tips for three in tip for c in three)))
        if now - posted > REPORT_EVERY or servo.link is Link.REFUSED:
            posted = now
            box.post(FROM_SERVO, pack_report(servo.report()))
        if servo.link is Link.REFUSED:
            return
        seen, letter = box.read(TO_SERVO, ORDER_SIZE, seen)  # after the answer: no device waits for Blender
        if letter:
            servo.order, heard = unpack_order(letter), time.perf_counter()


def listener(line: Line) -> Callable[[float], bytes | None]:
    """Return what waits for the next bytes of the line, b"" for none; None says that Blender is gone."""
    if WINDOWS:

        def by_orders(heard: float) -> bytes | None:
            line.wait(LOOK)
            return line.read() if time.perf_counter() - heard < BLENDER_GONE else None

        return by_orders

    stdin, port = sys.stdin.fileno(), line.fileno()
    arrivals = Arrivals(port, stdin)

    def by_pipe(_heard: float) -> bytes | None:
        ready = arrivals.wait(LOOK)
        if stdin in ready and not os.read(stdin, 4096):
            return None
        return line.read() if port in ready else b""

    return by_pipe


def hang_up(servo: Servo, line: Line) -> None:
    """Tell the device to let go, if it can still be told, and free the port."""
    try:
        line.write(servo.close())
        time.sleep(LAST_WORDS)
    except LinkLost:
        pass
    line.close()


def write_log(path: Path | None, log: list[LogRow] | None) -> None:
    """Write what the servo took and gave: time of the device [us], then position [m] and force [N] of each tip.

    Raises:
        DimpleError: it cannot be written.
    """
    if path and log is not None:
        try:
            path.write_text("".join(",".join(map(repr, row)) + "\n" for row in log), encoding="utf-8")
        except OSError as error:
            raise DimpleError(f"The servo's log {path} cannot be written: {error.strerror}.") from None
