"""The servo as a process of its own, as Blender starts it: line, mailbox and lifeline, with `Servo.step` between them.

Its standard input is the lifeline: the pipe closes when Blender ends, for whatever reason. The servo then disarms the
device, and the process ends.
"""

from __future__ import annotations

import argparse
import gc
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from ..errors import DimpleError
from . import priority
from .haply_line import PREFIX as HAPLY
from .haply_line import open_haply
from .limits import BLENDER_GONE, STATE_GAP, TICK
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .orders import LinkState, ServoReport, pack_report, unpack_order
from .process import SECRET
from .serial_line import WINDOWS, LineLost, Poller, SerialLine, open_line
from .servo import Servo
from .udp_line import PREFIX, open_udp
from .wire import BAUD


def main(words: list[str]) -> int:
    """Run the servo with the arguments of a command line until standard input closes; return its exit code."""
    parser = argparse.ArgumentParser(prog="start.py")
    add_options(parser)
    options = parser.parse_args(words)
    try:
        return run(Servo, options)
    except DimpleError as error:
        print(error, file=sys.stderr)
        return 2


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the servo."""
    parser.add_argument("port", help="serial port, path of a pseudo-terminal, udp:HOST:PORT, or haply:PORT")
    parser.add_argument("--mailbox", type=Path, required=True, metavar="FILE", help="made by Blender")
    parser.add_argument("--anywhere", action="store_true", help="on the network of other computers too")


def run(make_servo: Callable[..., Servo], options: argparse.Namespace) -> int:
    """Serve a line until standard input closes, and leave the device without force.

    Args:
        make_servo: Servo, or a function of a study that makes one with a log.
        options: see `add_options`.

    Returns:
        The exit code: 0, or 2 if the line was refused or lost; the last report says why.
    """
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    priority.request_priority()
    priority.keep_processors_awake()
    gc.disable()  # nothing here forms cycles, and a collection would delay a tick
    box, servo = Mailbox(options.mailbox), None
    try:
        servo = make_servo(nonce=os.getpid() & 0xFFFF)
        if options.port.startswith(PREFIX):
            line: SerialLine = open_udp(options.port, os.environ.get(SECRET, ""), anywhere=options.anywhere)
        elif options.port.startswith(HAPLY):
            line = open_haply(options.port)
        else:
            line = open_line(options.port, BAUD)
        try:
            serve(servo, line, box, listener(line))
        finally:
            release(servo, line)
        return 0 if servo.link is not LinkState.REFUSED else 2
    except DimpleError as error:
        link = LinkState.LOST if isinstance(error, LineLost) else LinkState.REFUSED
        report = servo.report() if servo else ServoReport()
        box.post(FROM_SERVO, pack_report(report._replace(link=link, note=str(error))))
        return 2
    finally:
        box.close()


def serve(servo: Servo, line: SerialLine, box: Mailbox, listen: Callable[[float], bytes | None]) -> None:
    """Answer the device until Blender ends or the device is refused.

    Raises:
        LineLost: the connection is lost.
    """
    seen, posted, ordered = 0, 0.0, time.perf_counter()
    while (data := listen(ordered)) is not None:
        now = time.perf_counter()
        out = servo.step(now, data)
        if out:
            servo.unsent += not line.write(out)
            box.post_sample(servo.sample())
        if now - posted > 2 * TICK or servo.link is LinkState.REFUSED:
            posted = now
            box.post(FROM_SERVO, pack_report(servo.report()))
        if servo.link is LinkState.REFUSED:
            return
        seen, message = box.read(TO_SERVO, seen)  # after the answer: no device waits for Blender
        if message:
            ordered = time.perf_counter()
            servo.order = unpack_order(message)


def listener(line: SerialLine) -> Callable[[float], bytes | None]:
    """Return a function that waits for the next bytes of the line; its argument is when the last order came [s].

    The function returns b"" if no bytes came, and None if Blender has ended.
    """
    if WINDOWS:

        def by_orders(ordered: float) -> bytes | None:
            line.wait(TICK)
            return line.read() if time.perf_counter() - ordered < BLENDER_GONE else None

        return by_orders

    stdin, port = sys.stdin.fileno(), line.fileno()
    poller = Poller(port, stdin)

    def by_pipe(_ordered: float) -> bytes | None:
        ready = poller.wait(TICK)
        if stdin in ready and not os.read(stdin, 4096):
            return None
        return line.read() if port in ready else b""

    return by_pipe


def release(servo: Servo, line: SerialLine) -> None:
    """Disarm the device if it can still be reached, and close the port."""
    try:
        line.write(servo.close())
        time.sleep(2 * STATE_GAP)  # until the bytes have left
    except LineLost:
        pass
    line.close()
