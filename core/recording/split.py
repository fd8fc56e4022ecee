"""Vertices for a graphics card, with one normal each: at a sharp edge, one vertex of the mesh becomes several."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

# factors of a hash of normals; odd ones are invertible modulo 2^64, so that no bit of a normal is lost
MIX = np.random.default_rng(0).integers(2**63, size=4, dtype=np.uint64) | np.uint64(1)


def split(
    corners: npt.NDArray[np.int32], normals: npt.NDArray[np.float32]
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the first corner (n,) of each split vertex, and the split vertex (corners,) of each corner.

    Corners share a split vertex if they have the same vertex and, in all frames, the same normal.

    Args:
        corners: (corners,) the vertex at each corner of the faces.
        normals: (frames, corners, 3) the normal at each corner.
    """
    mixed = np.zeros(len(corners), np.uint64)
    for normal in normals:
        bits = np.ascontiguousarray(normal, np.float32).view(np.uint32).astype(np.uint64)
        mixed = mixed * MIX[0] + (bits * MIX[1:]).sum(axis=1)
    order = np.lexsort((mixed, corners))
    begins = np.ones(len(order), bool)
    begins[1:] = (np.diff(corners[order]) != 0) | (np.diff(mixed[order]) != 0)
    which = np.empty(len(order), np.intp)
    which[order] = np.cumsum(begins) - 1
    return order[begins], which
