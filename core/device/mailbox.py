"""Messages between two processes in a shared file: Blender's order to the servo, the servo's report and its samples.

Each message has a sequence number that is odd while it is written (a seqlock), and its own CRC-32: a reader that comes
in between keeps the previous message, in whatever order a processor makes its stores visible.
"""

from __future__ import annotations

import mmap
import os
import struct
import tempfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from ..errors import DimpleError

_HEAD: Final = struct.Struct("<III")  # sequence number, CRC-32 and size [bytes] of the message
_SLOT: Final = 8192  # [bytes] for a message and its head: two pages, twice the longest order
TO_SERVO, FROM_SERVO = 0, 1
_SAMPLE: Final = struct.Struct("<Q19d")  # number; device time [s]; position [m] and force [N] of each tip
_SAMPLES: Final = 4096  # samples kept: four seconds at 1 kHz, longer than Blender can stall while a force acts
_SIZE: Final = 2 * _SLOT + _SAMPLES * _SAMPLE.size
MEMORY: Final = "/dev/shm"  # Linux keeps files there in memory: writing a page to a disk takes milliseconds


class Mailbox:
    """A mailbox file, mapped into memory.

    Args:
        path: of an existing file; None makes one. The process that opens an existing file removes it if the system
            allows: it stays mapped, and no file is left whichever process is killed. Otherwise `close` removes it in
            the process that made it.

    Raises:
        DimpleError: it cannot be made or opened.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._own = path is None
        try:
            self.path, self._map = _map(path)
        except (OSError, ValueError) as error:  # ValueError: the file is too short
            raise DimpleError(
                "Dimple cannot exchange data with the device's servo process: {where} ({error}).",
                where=path or _folder(), error=error
            ) from None  # fmt: skip

    def post(self, which: int, message: bytes) -> None:
        """Publish a message in place of the previous one."""
        if len(message) > _SLOT - _HEAD.size:
            raise ValueError(f"A message of {len(message)} bytes is too long.")
        at = which * _SLOT
        number = _HEAD.unpack_from(self._map, at)[0] | 1
        _HEAD.pack_into(self._map, at, number, 0, 0)
        self._map[at + _HEAD.size : at + _HEAD.size + len(message)] = message
        _HEAD.pack_into(self._map, at, (number + 1) & 0xFFFFFFFF, zlib.crc32(message), len(message))

    def read(self, which: int, seen: int = 0) -> tuple[int, bytes | None]:
        """Return the number of the newest message, and the message: None if already seen, or still being written.

        Args:
            which: TO_SERVO or FROM_SERVO.
            seen: number of the last message read, 0 for none.
        """
        at = which * _SLOT
        number, check, size = _HEAD.unpack_from(self._map, at)
        if number == seen or number & 1 or number == 0:
            return seen, None
        message = self._map[at + _HEAD.size : at + min(_HEAD.size + size, _SLOT)]
        whole = zlib.crc32(message) == check and _HEAD.unpack_from(self._map, at)[0] == number
        return (number, message) if whole else (seen, None)

    def post_sample(self, sample: Sequence[float]) -> None:
        """Publish a sample of the servo, see `Servo.sample`."""
        _SAMPLE.pack_into(self._map, 2 * _SLOT + int(sample[0]) % _SAMPLES * _SAMPLE.size, *sample)

    def samples(self, seen: int) -> tuple[int, list[tuple[float, ...]]]:
        """Return the number of the last sample returned, and all samples after number `seen`; the oldest may be lost.

        The newest may still be being written, so it is left for the next call.
        """
        rows = _SAMPLE.iter_unpack(self._map[2 * _SLOT :])
        found = sorted(row for row in rows if row[0] > seen)[:-1]
        return (found[-1][0] if found else seen), [row[1:] for row in found]

    def close(self) -> None:
        """Unmap the file; remove it if it was made here and still exists."""
        self._map.close()
        if self._own:
            self.path.unlink(missing_ok=True)


def _map(path: Path | None) -> tuple[Path, mmap.mmap]:
    """Return a mailbox file and its mapped bytes; None makes a file."""
    handle, name = (
        tempfile.mkstemp(dir=_folder(), prefix="dimple-", suffix=".mail")
        if path is None
        else (os.open(path, os.O_RDWR), str(path))
    )
    try:
        if path is None:
            os.write(handle, bytes(_SIZE))  # so that a full disk is reported now, not when a message is posted
        mapped = mmap.mmap(handle, _SIZE)
        if path is not None and os.name == "posix":
            path.unlink(missing_ok=True)
        return Path(name), mapped
    finally:
        os.close(handle)


def _folder() -> str:
    return MEMORY if os.access(MEMORY, os.W_OK) else tempfile.gettempdir()
