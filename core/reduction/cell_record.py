"""The seeds and cells of a proxy as a short text that a file can keep: to find them takes longer than to check them."""

from __future__ import annotations

import zlib
from base64 import b64decode, b64encode
from hashlib import blake2b

import numpy as np

from ..base import Floats, Ints

SMALLEST = 20_000  # vertices: the cells of a smaller mesh are found at once
VERSION = 1  # of how seeds and cells are found: another one finds them anew
CHECKED = 16  # bytes of the checksum
MOST = 1 << 16  # seeds


def packed(place: Floats, triangles: Ints, asked: int, seeds: Ints, cells: Ints) -> str:
    """Return seeds (m,) and cells (n,) as a text, "" where the mesh is so small that they are not worth one.

    Args:
        place: (n, 6) where the vertices are in the space of the cells.
        triangles: (t, 3) of the mesh.
        asked: how many seeds were to be spread.
    """
    if len(cells) < SMALLEST:
        return ""
    content = _content(seeds, cells)
    return b64encode(_checksum(place, triangles, asked, content) + zlib.compress(content)).decode()


def unpacked(text: str, place: Floats, triangles: Ints, asked: int) -> tuple[Ints, Ints] | None:
    """Return the seeds and cells in a text, None where it is damaged or was made of anything else."""
    most = 4 * MOST + 2 * len(place)
    try:
        record = b64decode(text)
        content = zlib.decompressobj().decompress(record[CHECKED:], most) if record else b""
    except (ValueError, zlib.error):
        return None
    m = (len(content) - 2 * len(place)) // 4
    if m < 1 or record[:CHECKED] != _checksum(place, triangles, asked, content):
        return None
    seeds = np.frombuffer(content, "<i4", m).astype(np.int64)
    cells = np.cumsum(np.frombuffer(content, "<u2", len(place), 4 * m), dtype=np.uint16).astype(np.int64)
    fits = seeds.min() >= 0 and seeds.max() < len(place) and cells.max() < m
    return (seeds, cells) if fits else None


def _content(seeds: Ints, cells: Ints) -> bytes:
    steps = np.diff(cells.astype("<u2"), prepend=np.zeros(1, "<u2"))  # mostly 0: neighbours are in one cell
    return seeds.astype("<i4").tobytes() + steps.astype("<u2").tobytes()


def _checksum(place: Floats, triangles: Ints, asked: int, content: bytes) -> bytes:
    checksum = blake2b(f"{VERSION} {asked} {place.shape} {triangles.shape}".encode(), digest_size=CHECKED)
    for array in (place, triangles):
        checksum.update(np.ascontiguousarray(array).data)
    checksum.update(content)
    return checksum.digest()
