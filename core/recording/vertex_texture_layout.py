"""Vertex animation textures: pictures whose pixels are the positions of vertices, for shaders and game engines.

Layout: vertex i of frame f (both from 0) is the pixel in column i % width and row f * rows + i // width, counted from
the top left. In `offsets`, red, green and blue are the x, y and z of the displacement of the vertex from its position
in mesh.glb, in the coordinates of that mesh: Y is up, as in glTF, so Blender's (x, y, z) is (x, z, -y) there. `bounds`
in layout.json are the least and greatest coordinates of any vertex in any frame. `normals` holds the normals in the
same coordinates. Both are OpenEXR with 32-bit floats, so they are exact. At a sharp edge each side has its own vertex.
The second UV map of the mesh points at the centre of a vertex's pixel in frame 0; with v upwards, each later frame is
rows / height lower. Sample without filtering, and as data, not as colour. If the object moves as a whole, the animation
of mesh.glb has that motion; its time 0 is frame 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import DimpleError, Singles

WIDEST = 8192  # [pixels] largest width and height of a texture that every graphics card supports


class Layout(NamedTuple):
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
            "{vertices} vertices in {frames} frames need an image {height} pixels high, but graphics cards support "
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
