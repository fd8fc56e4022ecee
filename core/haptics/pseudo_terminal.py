"""Run an emulated device behind a pseudo-terminal: the host opens it like any serial port."""

from __future__ import annotations

import gc
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType

from ..errors import DimpleError
from . import scheduling
from .emulator import Emulator
from .poller import MOST, Arrivals, take

MOST_LATE = 2e-3  # [s] when this process was kept from running for longer, the device's clock stood still meanwhile
LEAD = 1e-4  # [s] to wake up and compute in: what leaves a device at a tick leaves at it, and not when Python is done


class Stopped(Exception):
    """Say that the process was asked to end."""


def serve(emulator: Emulator, path: Path, seconds: float, *, lifeline: int | None = None) -> dict[str, float]:
    """Run a device until its time is over, it is unplugged, or SIGTERM or SIGINT come; print where it is.

    Args:
        path: of the port, a link that is made, and removed at the end.  seconds: to run.
        lifeline: descriptor of a pipe; when its other end closes, the device ends too.

    Returns:
        What the system did: real_time, 1 where it let this process go before others; slips and slipped_s, when it was
        kept from running and its clock stood still; overflows, frames that the line had no room for.

    Raises:
        DimpleError: the system has no pseudo-terminals, or the path is taken.
    """
    with _terminal(path) as master, _signals(), suppress(Stopped):
        print(f"{emulator.spec.name} (emulated) at {path}", flush=True)  # from now on it can be opened
        return _run(emulator, master, seconds, lifeline)
    return {}


def _run(emulator: Emulator, master: int, seconds: float, lifeline: int | None) -> dict[str, float]:
    first = scheduling.ask()  # it stands for hardware, which nothing keeps from running
    told = {"real_time": float(first == "real time"), "slips": 0.0, "slipped_s": 0.0, "overflows": 0.0}
    begin = time.monotonic()
    arrivals = Arrivals(master, *([] if lifeline is None else [lifeline]))
    gc.disable()  # nothing here makes cycles, and a sweep would be late
    with suppress(Stopped):
        while not emulator.unplugged and time.monotonic() - begin < seconds:
            now = time.monotonic() - told["slipped_s"]
            due = emulator.next_time() if emulator.started else now
            if now - due > MOST_LATE:
                told["slips"], told["slipped_s"], now = told["slips"] + 1, told["slipped_s"] + now - due, due
            ready = arrivals.wait(max(due - LEAD - now, 0.0))
            now = time.monotonic() - told["slipped_s"]  # as bytes come, like a device's interrupt, not once read
            if lifeline in ready and not os.read(lifeline, MOST):
                break
            if ready:
                outgoing = emulator.step(now, take(master))
            else:
                outgoing = emulator.step(max(now, due), b"")
                while outgoing and time.monotonic() - told["slipped_s"] < due:
                    pass
            if outgoing:
                told["overflows"] += not _write(master, outgoing)
    return told


def _write(master: int, data: bytes) -> bool:
    try:
        return os.write(master, data) == len(data)
    except BlockingIOError:
        return False


@contextmanager
def _terminal(path: Path) -> Iterator[int]:
    """Make a pseudo-terminal and a link to it; give the device's end."""
    try:
        import pty
        import tty
    except ImportError:
        raise DimpleError("This system has no pseudo-terminals; the emulator runs on Linux and macOS.") from None
    if os.path.exists(path):  # the link of an emulator that was killed leads nowhere, and is replaced
        raise DimpleError(
            f"{path} is there already, perhaps of another emulator. End that, or name a path that is free."
        )
    master, slave = pty.openpty()  # the host's end stays open here: between two hosts the line lives on
    try:
        tty.setraw(slave)
        os.set_blocking(master, False)
        name = _name(slave)
        try:
            path.unlink(missing_ok=True)
            path.symlink_to(name)
        except OSError as error:
            raise DimpleError(f"{path} cannot be made: {error.strerror}.") from None
        try:
            yield master
        finally:
            if path.is_symlink() and os.readlink(path) == name:
                path.unlink()
    finally:
        os.close(slave)
        os.close(master)


def _name(slave: int) -> str:
    """Return a path of the host's end that is gone with this process, where the system has such paths (Linux).

    The terminal's own name is soon that of somebody's terminal window, and a host would take that for the device.
    """
    own = f"/proc/{os.getpid()}/fd/{slave}"
    return own if os.path.exists(own) else os.ttyname(slave)


@contextmanager
def _signals() -> Iterator[None]:
    """Turn SIGTERM and SIGINT into Stopped."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Stopped

    before = [(number, signal.signal(number, stop)) for number in (signal.SIGTERM, signal.SIGINT)]
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)
