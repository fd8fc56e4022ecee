"""Run an emulated device behind a pseudo-terminal: the host opens it like any serial port."""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from core.device import priority
from core.device.serial_line import MAX_BYTES, Poller, take
from core.errors import DimpleError

from .emulator import Emulator

SUPPORTED: Final = hasattr(os, "openpty")  # Windows has no pseudo-terminals
UNSUPPORTED: Final = "This system has no pseudo-terminals; the emulated device runs on Linux and macOS."
MAX_LATENESS: Final = 2e-3  # [s] a process kept from running for longer than this stops its device's clock meanwhile
LEAD: Final = 1e-4  # [s] to wake up and compute in, so that what a device sends at a tick leaves at the tick


@dataclass(slots=True)
class ServeRecord:
    """What the system did to an emulated device.

    real_time: it granted real-time priority.
    slips: how often it kept the process from running for longer than MAX_LATENESS.
    slipped: for how long in all, while the device's clock stood still [s].
    overflows: frames that the line had no room for.
    """

    real_time: bool = False
    slips: int = 0
    slipped: float = 0.0
    overflows: int = 0


def serve(emulator: Emulator, path: Path, *, lifeline: int | None = None) -> ServeRecord:
    """Run a device until it is unplugged, or until its lifeline closes; print where its port is.

    Args:
        emulator: the device.
        path: of the port, a link that is made here and removed at the end.
        lifeline: descriptor of a pipe; when its other end closes, the device ends too.

    Raises:
        DimpleError: the system has no pseudo-terminals, or the path is taken.
    """
    with _terminal(path) as master:
        print(f"{emulator.spec.name} (emulated) at {path}", flush=True)  # from now on it can be opened
        return run(emulator, master, lifeline, lambda: take(master), lambda data: _write(master, data))


def run(
    emulator: Emulator, port: int, lifeline: int | None, read: Callable[[], bytes], write: Callable[[bytes], bool]
) -> ServeRecord:
    """Run a device on a descriptor: read returns all bytes there are, write tells whether they left; else `serve`."""
    # the emulator stands for hardware, which no other process delays
    record = ServeRecord(real_time=priority.request_priority())
    poller = Poller(port, *([] if lifeline is None else [lifeline]))
    gc.disable()  # nothing here makes cycles, and a collection would be late for a tick
    while not emulator.unplugged:
        now = time.monotonic() - record.slipped
        due = emulator.next_time() if emulator.started else now
        if now - due > MAX_LATENESS:
            record.slips, record.slipped, now = record.slips + 1, record.slipped + now - due, due
        ready = poller.wait(max(due - LEAD - now, 0.0))
        now = time.monotonic() - record.slipped  # when bytes come, as a device's interrupt would see it
        if lifeline in ready and not os.read(lifeline, MAX_BYTES):
            break
        if ready:
            outgoing = emulator.step(now, read())
        else:
            outgoing = emulator.step(max(now, due), b"")
            while outgoing and time.monotonic() - record.slipped < due:
                pass
        if outgoing:
            record.overflows += not write(outgoing)
    return record


def _write(master: int, data: bytes) -> bool:
    try:
        return os.write(master, data) == len(data)
    except BlockingIOError:
        return False


@contextmanager
def _terminal(path: Path) -> Iterator[int]:
    """Make a pseudo-terminal and a link to it; yield the device's end."""
    if not SUPPORTED:
        raise DimpleError(UNSUPPORTED)
    import tty

    if os.path.exists(path):  # the link of an emulator that was killed is broken, and is replaced
        raise DimpleError(
            "{path} exists already, perhaps from another emulator. End that one, or choose a free path.", path=path
        )
    master, slave = os.openpty()  # the host's end stays open here, so that the line survives between two hosts
    try:
        tty.setraw(slave)
        os.set_blocking(master, False)
        name = _name(slave)
        try:
            path.unlink(missing_ok=True)
            path.symlink_to(name)
        except OSError as error:
            raise DimpleError("{path} cannot be made: {error}.", path=path, error=error.strerror) from None
        try:
            yield master
        finally:
            if path.is_symlink() and os.readlink(path) == name:
                path.unlink()
    finally:
        os.close(slave)
        os.close(master)


def _name(slave: int) -> str:
    """Return a path of the host's end that vanishes with this process, where the system has such paths (Linux).

    The terminal's own name is reused soon, by some terminal window, and a host would take that for the device.
    """
    own = f"/proc/{os.getpid()}/fd/{slave}"
    return own if os.path.exists(own) else os.ttyname(slave)
