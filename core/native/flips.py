"""The call that flips the edges of a proxy's mesh."""

from __future__ import annotations

import ctypes

import numpy as np

from ..base import Floats, Ints
from .body import call
from .definition import Arrays


def flip_edges(library: ctypes.CDLL, points: Floats, triangles: Ints) -> Ints:
    """Return triangles (t, 3) on the same points (n, 3), edges flipped towards Delaunay where the surface is flat.

    Raises:
        NativeError: a vertex that does not exist, or no memory.
    """
    flipped = np.array(triangles, np.int64, order="C")
    with Arrays() as arrays:
        call(library, "dm_flip_edges", len(points), arrays.double(points), len(flipped), flipped.ctypes.data)
    return flipped
