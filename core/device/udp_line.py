"""A line to a device on the network: a UDP socket in place of a serial port, with the same frames.

A datagram holds whole frames. What is lost, late or doubled there is dropped by its sequence number as on a serial
line; a device that falls silent has no force after 5 ms and is lost after 100 ms. Only its own address is heard.
"""

from __future__ import annotations

import select
import socket
from typing import Final

from ..errors import DimpleError
from .serial_line import MAX_BYTES, SerialLine

PREFIX: Final = "udp:"
EXAMPLE: Final = "udp:127.0.0.1:7400"


class UdpLine(SerialLine):
    """An open socket to one device."""

    def read(self) -> bytes:
        """Return all there is, b"" where there is nothing."""
        parts = []
        while True:
            try:
                parts.append(self._port.recv(MAX_BYTES))
            except BlockingIOError:
                return b"".join(parts)
            except ConnectionRefusedError:  # nobody listens there now: silence, which the servo judges
                continue
            except OSError as error:
                raise self._gone(error) from None

    def write(self, data: bytes) -> bool:
        """Send bytes; return False where they did not leave."""
        try:
            return self._port.send(data) == len(data)
        except (BlockingIOError, ConnectionRefusedError):
            return False
        except OSError as error:
            raise self._gone(error) from None

    def wait(self, seconds: float) -> bool:
        """Wait for bytes, at most for a time [s]; tell whether there are some."""
        return bool(select.select([self._port], [], [], seconds)[0])


def open_udp(path: str) -> UdpLine:
    """Open a socket to "udp:HOST:PORT".

    Raises:
        DimpleError: it is no address, or cannot be reached.
    """
    host, _, number = path.removeprefix(PREFIX).rpartition(":")
    if not host or not number.isdecimal() or not 0 < int(number) < 0x10000:
        raise DimpleError("{path} is not an address of a device. Write it as {example}.", path=path, example=EXAMPLE)
    port = None
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, int(number), type=socket.SOCK_DGRAM)[0]
        port = socket.socket(family, kind, protocol)
        port.setblocking(False)
        port.connect(address)  # from now on only that address is heard
    except OSError as error:
        if port:
            port.close()
        raise DimpleError("{path} cannot be reached ({error}).", path=path, error=error.strerror or error) from None
    return UdpLine(port, path)
