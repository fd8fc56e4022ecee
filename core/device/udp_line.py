"""A line to a device on the network: a UDP socket in place of a serial port, with the same frames.

A datagram holds whole frames under a seal (seal.py). Sequence numbers reveal lost frames; late and duplicate ones are
dropped. A device that falls silent has no force after 5 ms and is lost after 100 ms.
"""

from __future__ import annotations

import ipaddress
import select
import socket
from typing import Final

from ..errors import DimpleError
from .seal import SHORTEST_SECRET, Seal
from .serial_line import MAX_BYTES, SerialLine

PREFIX: Final = "udp:"
EXAMPLE: Final = "udp:127.0.0.1:7400"


class SocketLine(SerialLine):
    """An open socket in place of a serial port."""

    def wait(self, seconds: float) -> bool:
        """Wait for bytes for at most a time [s]; return whether there are any."""
        return bool(select.select([self._port], [], [], seconds)[0])


class UdpLine(SocketLine):
    """An open socket to one device."""

    def __init__(self, port: socket.socket, name: str, seal: Seal) -> None:
        super().__init__(port, name)
        self._seal = seal

    def read(self) -> bytes:
        """Return the frames of all waiting datagrams, b"" if there are none."""
        parts = []
        while True:
            try:
                parts.append(self._seal.open(self._port.recv(MAX_BYTES)))
            except BlockingIOError:
                return b"".join(parts)
            except ConnectionError:  # nothing listens there now: silence, which the servo handles
                continue
            except OSError as error:
                raise self._gone(error) from None

    def write(self, data: bytes) -> bool:
        """Send frames; return False if they could not be sent."""
        try:
            return bool(self._port.send(self._seal.close(data)))
        except (BlockingIOError, ConnectionError):
            return False
        except OSError as error:
            raise self._gone(error) from None


def open_udp(path: str, secret: str, *, anywhere: bool = False) -> UdpLine:
    """Open a socket to "udp:HOST:PORT".

    Args:
        path: the address.
        secret: shared with the device.
        anywhere: allow other computers than this one.

    Raises:
        DimpleError: the address is invalid, not allowed or cannot be reached, or the secret is too short.
    """
    host, _, number = path.removeprefix(PREFIX).rpartition(":")
    if not host or not number.isdecimal() or not 0 < int(number) < 0x10000:
        raise DimpleError("{path} is not the address of a device. Write it as {example}.", path=path, example=EXAMPLE)
    if len(secret) < SHORTEST_SECRET:
        raise DimpleError(
            "A network device needs the secret that it shares with Dimple, at least {shortest} characters long. "
            "Enter it in Dimple's preferences.",
            shortest=SHORTEST_SECRET
        )  # fmt: skip
    port = None
    try:
        found = socket.getaddrinfo(host.strip("[]"), int(number), type=socket.SOCK_DGRAM)[0]
        family, kind, protocol, _, address = found
        if not anywhere and not ipaddress.ip_address(str(address[0]).partition("%")[0]).is_loopback:
            raise DimpleError(
                "{path} is another computer. To reach it, switch on Devices on Other Computers in Dimple's "
                "preferences, and Allow Online Access in Blender's.", path=path
            )  # fmt: skip
        port = socket.socket(family, kind, protocol)
        port.setblocking(False)
        port.connect(address)  # from now on only datagrams of that address are received
    except OSError as error:
        if port:
            port.close()
        raise DimpleError("{path} cannot be reached ({error}).", path=path, error=error.strerror or error) from None
    return UdpLine(port, path, Seal(secret))
