"""The seal of a datagram: on a network only someone who knows the secret of a device can move the hand on it.

A datagram is: number of the receiving end, number of the sending end (8 bytes each, drawn at random when that end
starts), its sequence number (8 bytes, little-endian), whole frames, and a keyed BLAKE2s (16 bytes) of all that.
A datagram by anybody else or for another session is dropped, and so is a replayed one.
"""

from __future__ import annotations

import hmac
import math
import secrets
import struct
import time
from hashlib import blake2s
from typing import Final

from .limits import LOST_TIME

NOBODY: Final = bytes(8)  # stands for an end whose number is not known
SHORTEST_SECRET: Final = 16  # [characters] 64 bits if they are hexadecimal
_HEAD: Final = struct.Struct("<8s8sQ")
_MAC_SIZE: Final = 16


class Seal:
    """One end of a sealed line.

    Args:
        secret: text that both ends know.

    Attributes:
        heard: when the other end was last heard [s]; one that is silent may have started again, under a new number.
    """

    def __init__(self, secret: str) -> None:
        self._key = blake2s(secret.encode()).digest()
        self.own, self.other, self._count, self.heard = secrets.token_bytes(8), NOBODY, 0, -math.inf
        self._newest: dict[bytes, int] = {}  # last sequence number taken from each sending end

    def close(self, frames: bytes) -> bytes:
        """Return frames as a datagram for the other end."""
        self._count += 1
        other = self.other if time.monotonic() - self.heard < LOST_TIME else NOBODY
        body = _HEAD.pack(other, self.own, self._count) + frames
        return body + self._mac(body)

    def open(self, datagram: bytes) -> bytes:
        """Return the frames of a datagram, b"" if it is not from the other end, not for this one, or not new."""
        body, mac = datagram[:-_MAC_SIZE], datagram[-_MAC_SIZE:]
        if len(body) < _HEAD.size or not hmac.compare_digest(mac, self._mac(body)):
            return b""
        to, other, count = _HEAD.unpack_from(body)
        newest = self._newest.get(other, 0)
        if not self._is_mine(to) or count <= newest or (newest and other != self.other):
            return b""
        self.other = other  # a new end may take over; the one that it replaced is refused from now on
        self._newest[other], self.heard = count, time.monotonic()
        return body[_HEAD.size :]

    def _is_mine(self, to: bytes) -> bool:
        return to == self.own

    def _mac(self, body: bytes) -> bytes:
        return blake2s(body, digest_size=_MAC_SIZE, key=self._key).digest()
