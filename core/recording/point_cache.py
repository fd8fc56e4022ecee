"""Recordings: a PC2 point cache, the format that Blender's Mesh Cache modifier plays.

Format: "POINTCACHE2" NUL, then int32 version 1, int32 vertices, float32 start frame, float32 sample rate, int32
samples, then float32 (samples, vertices, 3), little-endian.
"""

from __future__ import annotations

import math
import os
import struct
from pathlib import Path
from types import TracebackType

import numpy as np
import numpy.typing as npt

from ..base import DimpleError

_HEADER = struct.Struct("<12siiffi")
_MAGIC = b"POINTCACHE2\0"


class PointCache:
    """Write a PC2 file sample by sample; appended samples survive a crash of the program.

    Each sample is handed to the system before the header counts it, so an incomplete last sample is never read, even if
    the disk is full. Only `close` waits for the disk itself: a power cut may destroy an unfinished recording.

    Args:
        path: file to create.
        n_vertices: number of vertices in each sample.
        start_frame: frame of the first sample.
    """

    def __init__(self, path: str | os.PathLike[str], n_vertices: int, start_frame: float = 1.0) -> None:
        self.path, self.n_vertices, self.samples = Path(path), n_vertices, 0
        self._file = self.path.open("w+b", buffering=0)  # no data stays in a buffer if a write fails
        try:
            self._write(0, _HEADER.pack(_MAGIC, 1, n_vertices, start_frame, 1.0, 0))
        except OSError:
            self._file.close()
            raise

    def append(self, positions: npt.ArrayLike) -> None:
        """Add one sample (n_vertices, 3).

        Raises:
            DimpleError: another number of vertices, or coordinates that are not numbers.
            OSError: the sample cannot be written; the samples before it are kept.
        """
        sample = np.ascontiguousarray(positions, dtype="<f4")
        if sample.shape != (self.n_vertices, 3):
            raise DimpleError(
                "The animation has {vertices} vertices, and the mesh now has {now}. Bake again.",
                vertices=self.n_vertices, now=len(sample)
            )  # fmt: skip
        if not np.isfinite(sample).all():
            raise DimpleError(
                "Sample {sample} has coordinates that are not numbers; it was not written.", sample=self.samples + 1
            )
        self._write(_HEADER.size + self.samples * sample.nbytes, sample.tobytes())
        self._write(_HEADER.size - 4, struct.pack("<i", self.samples + 1))
        self.samples += 1

    def close(self) -> None:
        """Wait until everything is on the disk and close the file; closing twice does nothing.

        Raises:
            OSError: the file cannot be synchronised; it is closed nevertheless.
        """
        if self._file.closed:
            return
        try:
            os.fsync(self._file.fileno())
        finally:
            self._file.close()

    def __enter__(self) -> PointCache:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write(self, at: int, data: bytes) -> None:
        self._file.seek(at)
        left = memoryview(data)
        while left:  # an almost full disk accepts a part, and the next write raises an error
            left = left[self._file.write(left) :]


def open_point_cache(path: str | os.PathLike[str]) -> tuple[float, npt.NDArray[np.float32]]:
    """Open a PC2 file as a memory map.

    Returns:
        start frame, positions (samples, vertices, 3) that are read from the disk on access.

    Raises:
        DimpleError: not a PC2 file, a truncated one, or one that is not sampled once per frame.
        OSError: it cannot be read.
    """
    name = Path(path).name
    with Path(path).open("rb") as file:
        header = file.read(_HEADER.size)
        size = os.fstat(file.fileno()).st_size
    if len(header) < _HEADER.size or header[:16] != _MAGIC + b"\1\0\0\0":
        raise DimpleError("{name} is not a PC2 point cache.", name=name)
    _, _, vertices, start, rate, samples = _HEADER.unpack(header)
    if vertices < 1 or samples < 1 or size < _HEADER.size + 12 * vertices * samples or not math.isfinite(start):
        raise DimpleError("{name} is a PC2 point cache that was cut short. Bake again.", name=name)
    if rate != 1:
        raise DimpleError(
            "{name} has a sample every {rate:g} frames, not one a frame. Bake again.", name=name, rate=rate
        )
    return start, np.memmap(path, "<f4", "r", _HEADER.size, (samples, vertices, 3))
