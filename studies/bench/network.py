"""The device's end of a network line: it serves one host, which knows its secret, and hears nobody else meanwhile."""

from __future__ import annotations

import socket
import time
from typing import Final

from core.device.seal import NOBODY, Seal
from core.device.serial_line import MAX_BYTES

OWNED: Final = 0.3  # [s] after its host's last datagram a device still belongs to it


class DeviceSeal(Seal):
    """A device's end: a host that does not know its number yet is heard where there is no other."""

    def _is_mine(self, to: bytes) -> bool:
        return super()._is_mine(to) or (to == NOBODY and time.monotonic() - self.heard > OWNED)


class DeviceLine:
    """A socket of a device on this computer.

    Args:
        number: of the port.
        secret: what its host must know.
    """

    def __init__(self, number: int, secret: str) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", number))
        self._socket.setblocking(False)
        self._seal, self._host = DeviceSeal(secret), ("", 0)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._socket.fileno()

    def read(self) -> bytes:
        """Return the frames of all datagrams of its host."""
        parts: list[bytes] = []
        while True:
            try:
                datagram, sender = self._socket.recvfrom(MAX_BYTES)
            except BlockingIOError:
                return b"".join(parts)
            except ConnectionError:  # of something sent to a host that is gone
                continue
            if frames := self._seal.open(datagram):
                self._host = sender
                parts.append(frames)

    def write(self, data: bytes) -> bool:
        """Send frames to its host; return False where they did not leave."""
        try:
            return bool(self._host[1] and self._socket.sendto(self._seal.close(data), self._host))
        except (BlockingIOError, ConnectionError):
            return False

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
