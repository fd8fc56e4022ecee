"""The calls that grow cells on a fine surface and list what its vertices follow, and their structure of dimple.h."""

from __future__ import annotations

import ctypes
from ctypes import Structure, byref
from typing import Any

import numpy as np

from ..base import Bools, Floats, Ints, Shorts
from ..constants import FOLLOWED, LANES
from .body import call
from .definition import Arrays, fields


class CCells(Structure):
    """Seeds on a fine surface: dm_cells."""

    _fields_ = fields(vertices="n", place="p", edges="n", ends="p", seeds="n", seed="p")


def grow_cells(library: ctypes.CDLL, ends: Ints, place: Floats, seeds: Ints) -> tuple[Ints, Bools]:
    """Return the seed (n,) of each vertex, -1 if no cell reaches it, and whether its cell connects it to the seed (n,).

    Each vertex takes the nearest of its neighbours' seeds, the first of two that are equally near.

    Args:
        ends: (m, 2) vertices of the edges.
        place: (n, 6) positions of the vertices in the space of the cells [m].
        seeds: indices of the vertices that are seeds.

    Raises:
        NativeError: a vertex that does not exist, or no memory.
    """
    cells, joined = np.empty(len(place), np.int64), np.empty(len(place), np.uint8)
    with Arrays() as arrays:
        surface = _surface(arrays, ends, place, seeds)
        call(library, "dm_grow_cells", byref(surface), cells.ctypes.data, joined.ctypes.data)
    return cells, joined.astype(bool)


def follow_cells(
    library: ctypes.CDLL, place: Floats, seeds: Ints, cells: Ints, around: Ints
) -> tuple[Ints, Shorts, Shorts]:
    """List the nearest of the seeds around the cell of each vertex, and their weights.

    Args:
        around: (m, w) seeds around each cell, each row padded with -1.

    Returns:
        first (g + 1,), followed (p,) and weights (p, 8) of a `Binding`.

    Raises:
        NativeError: a vertex or seed that does not exist.
    """
    eights = -(-len(place) // LANES)
    first, room = np.empty(eights + 1, np.int64), LANES * FOLLOWED * eights
    followed, weights = np.empty(room, np.uint16), np.empty((room, LANES), np.uint16)  # most of it stays untouched
    with Arrays() as arrays:
        surface = _surface(arrays, np.empty((0, 2), np.int64), place, seeds)
        given = byref(surface), arrays.index(cells), around.shape[1], arrays.index(around)
        call(library, "dm_follow_cells", *given, *(a.ctypes.data for a in (first, followed, weights)))
    return first, followed[: first[-1]].copy(), weights[: first[-1]].copy()


def farthest_first(library: ctypes.CDLL, places: Floats, taken: int, least: float, most: int) -> Ints:
    """Choose points one by one, each the farthest from all those chosen before.

    Args:
        places: (n, 6) positions in the space of the cells [m].
        taken: number of leading points that count as chosen already.
        least: squared distance at or below which a point is too near to be chosen [m2].
        most: largest number of points to choose.
    """
    chosen = np.empty(max(most, 0), np.int64)
    with Arrays() as arrays:
        given = len(places), arrays.double(places), taken, least, most, chosen.ctypes.data
        return chosen[: library.dm_farthest_first(*given)]


def _surface(arrays: Arrays, ends: Ints, place: Floats, seeds: Ints) -> CCells:
    given: list[Any] = [len(place), arrays.double(place), len(ends), arrays.index(ends)]
    return CCells(*given, len(seeds), arrays.index(seeds))
