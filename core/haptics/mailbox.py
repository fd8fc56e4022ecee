"""Two letters that two processes share in a file: what Blender says to the servo, and what the servo says back.

Each letter is written under a sequence number that is odd meanwhile (a seqlock), and carries its own CRC-32: a
reader that comes in between takes the one before, whatever the order in which a processor shows its stores.
"""

from __future__ import annotations

import mmap
import os
import struct
import tempfile
import zlib
from pathlib import Path
from typing import Final

from ..errors import DimpleError

_HEAD: Final = struct.Struct("<II")  # sequence number, CRC-32 of the letter
_LETTER: Final = 4096  # bytes for each letter and its head
TRIES = 4
TO_SERVO, FROM_SERVO = 0, 1
MEMORY: Final = "/dev/shm"  # files in memory, on Linux: a page written to a disk keeps the writer waiting for ms


class Mailbox:
    """Map a mailbox file.

    path: of the file; None makes one. Who is given it removes it where the system lets him: it stays mapped, and
    nothing is left behind whoever is killed. Else `close` does where it was made.

    Raises:
        DimpleError: it cannot be made or opened.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._own = path is None
        try:
            self.path, self._map = _map(path)
        except (OSError, ValueError) as error:  # ValueError: a file that is shorter
            where = path or _folder()
            raise DimpleError(f"The mailbox of the device's servo cannot be used: {where} ({error}).") from None

    def post(self, which: int, letter: bytes) -> None:
        """Publish a letter in place of the last one."""
        if len(letter) > _LETTER - _HEAD.size:
            raise ValueError(f"A letter of {len(letter)} bytes is too long.")
        at = which * _LETTER
        number = _HEAD.unpack_from(self._map, at)[0] | 1
        _HEAD.pack_into(self._map, at, number, 0)
        self._map[at + _HEAD.size : at + _HEAD.size + len(letter)] = letter
        _HEAD.pack_into(self._map, at, (number + 1) & 0xFFFFFFFF, zlib.crc32(letter))

    def read(self, which: int, size: int, seen: int = 0) -> tuple[int, bytes | None]:
        """Return the number of the newest letter, and the letter: None where it was seen, or is being written.

        Args:
            size: of the letter [bytes].  seen: number of the one that was read last, 0 for none.
        """
        at = which * _LETTER
        for _ in range(TRIES):
            number, check = _HEAD.unpack_from(self._map, at)
            if number == seen or number & 1 or number == 0:
                return seen, None
            letter = self._map[at + _HEAD.size : at + _HEAD.size + size]
            if zlib.crc32(letter) == check and _HEAD.unpack_from(self._map, at)[0] == number:
                return number, letter
        return seen, None

    def close(self) -> None:
        """Let go of the file; remove it if it was made here and is still there."""
        self._map.close()
        if self._own:
            self.path.unlink(missing_ok=True)


def _map(path: Path | None) -> tuple[Path, mmap.mmap]:
    """Return a mailbox file and its bytes; None makes one."""
    if path is None:
        handle, name = tempfile.mkstemp(dir=_folder(), prefix="dimple-", suffix=".mail")
    else:
        handle, name = os.open(path, os.O_RDWR), str(path)
    try:
        if path is None:
            os.write(handle, bytes(2 * _LETTER))  # a full disk is known now, and not when a letter is posted
        mapped = mmap.mmap(handle, 2 * _LETTER)
        if path is not None and os.name == "posix":
            path.unlink(missing_ok=True)
        return Path(name), mapped
    finally:
        os.close(handle)


def _folder() -> str:
    return MEMORY if os.access(MEMORY, os.W_OK) else tempfile.gettempdir()
