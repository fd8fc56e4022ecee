"""Vertex animation textures: pictures whose pixels are the positions of vertices, for shaders and game engines.

Layout: vertex i of frame f (both from 0) is the pixel in column i % width and row f * rows + i // width, counted from
the top left. In `offsets`, red, green and blue are the x, y and z of the displacement of the vertex from its position
in mesh.glb, in the coordinates of that mesh: Y is up, as in glTF, so Blender's (x, y, z) is (x, z, -y) there. `bounds`
in layout.json are the least and greatest coordinates of any vertex in any frame. `normals.png` holds the normals in the
same coordinates: 0 stands for -1 and 65535 for 1. At a sharp edge each side has its own vertex. The second UV map of
the mesh points at the centre of a vertex's pixel in frame 0; with v upwards, each later frame is rows / height lower.
The EXR holds exact values; in the 16-bit offsets.png, 0 stands for `least` and 65535 for `most`, both in layout.json,
so the error of a coordinate is at most (most - least) / 131070. Sample without filtering, and as data, not as colour.
If the object moves as a whole, the animation of mesh.glb has that motion; its time 0 is frame 0.
"""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..base import DimpleError

WIDEST = 8192  # [pixels] largest width and height of a texture that every graphics card supports
Singles = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Layout:
    """The layout of a texture: its width and height [pixels], and its rows per frame."""

    width: int
    height: int
    rows: int


def layout(vertices: int, frames: int) -> Layout:
    """Return the layout for a number of vertices and of frames.

    Raises:
        DimpleError: the picture would be too large for graphics cards.
    """
    rows = -(-vertices // WIDEST)
    width = -(-vertices // rows)
    if rows * frames > WIDEST:
        raise DimpleError(
            "{vertices} vertices in {frames} frames need a picture {height} pixels high, and graphics cards take "
            "{widest}. Export at most {most} frames.",
            vertices=vertices, frames=frames, height=rows * frames, widest=WIDEST, most=WIDEST // rows
        )  # fmt: skip
    return Layout(width, rows * frames, rows)


def pixels(samples: Singles, where: Layout) -> Singles:
    """Return the picture (height, width, 3), top row first, of samples (frames, vertices, 3)."""
    frames, vertices, _ = samples.shape
    empty = where.rows * where.width - vertices
    return np.pad(samples, ((0, 0), (0, empty), (0, 0))).reshape(frames * where.rows, where.width, 3)


def uv(vertices: int, where: Layout) -> Singles:
    """Return the second UV map (vertices, 2), with v upwards."""
    number = np.arange(vertices)
    u, v = (number % where.width + 0.5) / where.width, 1 - (number // where.width + 0.5) / where.height
    return np.column_stack([u, v]).astype(np.float32)


def write_exr(path: str | os.PathLike[str], picture: Singles) -> None:
    """Write a picture (height, width, 3) as uncompressed OpenEXR with 32-bit floats.

    Raises:
        OSError: the file cannot be written.
    """
    height, width, _ = picture.shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    attributes = (
        ("channels", "chlist", channels), ("compression", "compression", b"\0"), ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window), ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)), ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    )  # fmt: skip
    head = struct.pack("<2i", 20000630, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    head += b"\0"
    line = 8 + 12 * width
    with Path(path).open("wb") as file:
        file.write(head)
        file.write((len(head) + 8 * height + line * np.arange(height)).astype("<u8").tobytes())
        for y, row in enumerate(picture):
            file.write(struct.pack("<2i", y, 12 * width) + np.ascontiguousarray(row.T[::-1], "<f4").tobytes())


def write_png(path: str | os.PathLike[str], picture: Singles, least: float, most: float) -> None:
    """Write a picture (height, width, 3) as 16-bit PNG, in which 0 stands for `least` and 65535 for `most`.

    Raises:
        OSError: the file cannot be written.
    """
    height, width, _ = picture.shape
    packer = zlib.compressobj(6)
    with Path(path).open("wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        _chunk(file, b"IHDR", struct.pack(">2I5B", width, height, 16, 2, 0, 0, 0))
        for row in picture:
            share = (row.astype(np.float64) - least) / max(most - least, 1e-30)
            _chunk(file, b"IDAT", packer.compress(b"\0" + np.rint(65535 * share).astype(">u2").tobytes()))
        _chunk(file, b"IDAT", packer.flush())
        _chunk(file, b"IEND", b"")


def _chunk(file: object, kind: bytes, data: bytes) -> None:
    if data or kind == b"IEND":
        file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))  # type: ignore[attr-defined]
