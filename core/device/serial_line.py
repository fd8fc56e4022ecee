"""The serial line to a device: non-blocking reads and writes, and one exception for every way to lose it."""

from __future__ import annotations

import errno
import os
import select
import time
from typing import Any, Final

from ..errors import DimpleError
from ..message import Message
from .limits import TICK

WINDOWS: Final = os.name == "nt"
EDGE_TRIGGERED: Final = hasattr(select, "epoll")
MAX_BYTES: Final = 65536  # [bytes] largest read: no datagram is longer
IN_USE: Final = {errno.EAGAIN, errno.EWOULDBLOCK, errno.EBUSY}


class LineLost(DimpleError):
    """The line is lost: it must be opened and armed again."""


class SerialLine:
    """An open serial line; all methods but `close` raise LineLost if it is lost."""

    def __init__(self, port: Any, name: str) -> None:
        self.name = name
        self._port, self._lost = port, lost_errors()

    def read(self) -> bytes:
        """Return all waiting bytes, b"" if there are none."""
        try:
            data = b"" if WINDOWS else take(self._port.fileno())
            # if nothing is waiting, only a read by pyserial shows that the other end is gone
            return data or self._port.read(max(self._port.in_waiting, 1))
        except self._lost as error:
            raise self._gone(error) from None

    def write(self, data: bytes) -> bool:
        """Send bytes; return False if the line did not accept them all; the rest is not sent later."""
        try:
            # pyserial retries forever on a full queue, and a query for room first can take milliseconds (see Poller)
            sent = self._port.write(data) if WINDOWS else os.write(self._port.fileno(), data)
        except BlockingIOError:
            sent = 0
        except self._lost as error:
            raise self._gone(error) from None
        return bool(sent == len(data))

    def wait(self, seconds: float) -> bool:
        """Wait for bytes for at most a time [s]; return whether there are any, or `read` will raise."""
        try:
            end = time.perf_counter() + seconds
            while not self._port.in_waiting and time.perf_counter() < end:
                time.sleep(TICK / 2)
            return bool(self._port.in_waiting)
        except self._lost as error:
            raise self._gone(error) from None

    def fileno(self) -> int:
        """Return the descriptor, for a select with others (not on Windows)."""
        return int(self._port.fileno())

    def close(self) -> None:
        """Close the line, even a lost one."""
        try:
            self._port.close()
        except self._lost:
            pass

    def _gone(self, error: BaseException) -> LineLost:
        return LineLost(
            "The connection to {name} is lost ({error}). Check its cable or network, connect, then arm again.",
            name=self.name, error=getattr(error, "strerror", None) or error
        )  # fmt: skip


def lost_errors() -> tuple[type[Exception], ...]:
    """Return the exceptions that an unplugged port raises: pyserial's, the system's, and those pyserial lets through.

    in_waiting raises a bare OSError or termios.error; a port that is closed during a read raises TypeError.
    """
    import serial

    errors: tuple[type[Exception], ...] = (serial.SerialException, OSError, TypeError)
    if not WINDOWS:
        import termios

        errors += (termios.error,)
    return errors


def open_line(path: str, baud: int) -> SerialLine:
    """Open a port exclusively.

    Args:
        path: /dev/ttyUSB0, COM3, or a pseudo-terminal.
        baud: rate [bit/s].

    Raises:
        DimpleError: the port is in use, missing, not permitted, or cannot run at this baud rate.
    """
    import serial

    errors: tuple[type[Exception], ...] = (*lost_errors(), ValueError, AttributeError, NotImplementedError)
    try:
        port = serial.Serial(path, baud, timeout=0, write_timeout=0, exclusive=True)
    except errors as error:
        raise DimpleError(_refusal(path, baud, error)) from None
    try:
        port.set_low_latency_mode(True)  # latency of a USB adapter: 1 ms instead of 16 ms
    except errors:
        pass  # a pseudo-terminal has no such mode; other systems set it elsewhere
    return SerialLine(port, path)


def _refusal(path: str, baud: int, error: Exception) -> str:
    number, text = getattr(error, "errno", None), str(error)
    if number in IN_USE or "PermissionError(13" in text:  # the latter on Windows
        return Message(
            "{path} is in use by another program, or another Blender. Close that one, then connect again.", path=path
        )
    if number == errno.ENOENT or "FileNotFoundError(2" in text:
        return Message("There is no port {path}. Is the device plugged in? Choose the port again.", path=path)
    if number in (errno.EACCES, errno.EPERM):
        return Message(
            "This account may not open {path}. On Linux, join the group dialout (or uucp), then log in again.",
            path=path,
        )
    if isinstance(error, ValueError):
        return Message("{path} cannot run at {baud} baud ({text}).", path=path, baud=baud, text=text)
    return Message("{path} is not a serial port that can be opened ({text}).", path=path, text=text)


def ports() -> list[tuple[str, str]]:
    """Return the ports of this computer and their descriptions; pseudo-terminals are never among them."""
    from serial.tools import list_ports

    return sorted((port.device, port.description) for port in list_ports.comports())


class Poller:
    """Watch descriptors. Each is returned once for all bytes that arrived since, and when its other end closes.

    On Linux a query whether a terminal has bytes (select, or a read without any) waits for the kernel worker that
    delivers them. A real-time process takes the processor from that worker just as it is notified; any other load on
    that processor then delays the worker, and so the query, by 1 to 4 ms. An edge-triggered watch needs no query.
    """

    def __init__(self, *descriptors: int) -> None:
        self._descriptors = descriptors
        if EDGE_TRIGGERED:
            self._epoll = select.epoll()
            for each in descriptors:
                self._epoll.register(each, select.EPOLLIN | select.EPOLLET)

    def wait(self, seconds: float) -> list[int]:
        """Return the descriptors on which bytes have arrived, after at most a time [s]."""
        if not EDGE_TRIGGERED:
            return select.select(self._descriptors, [], [], seconds)[0]
        if seconds < 1e-3:  # epoll has a resolution of a millisecond
            select.select([self._epoll], [], [], seconds)
            seconds = 0
        return [each for each, _ in self._epoll.poll(seconds)]


def take(descriptor: int) -> bytes:
    """Return the waiting bytes, b"" if there are none."""
    try:
        return os.read(descriptor, MAX_BYTES)
    except BlockingIOError:
        return b""
