"""The call that carries a fine surface by the motion of a proxy, and its structure of dimple.h."""

from __future__ import annotations

import ctypes
from ctypes import Structure, byref

import numpy as np
import numpy.typing as npt

from ..base import Floats, Singles
from .body import NativeError
from .definition import fields

FOLLOWED = 8  # vertices of a proxy that a vertex of its surface follows
LINE = 16  # numbers of single precision in a line of the cache
Shorts = npt.NDArray[np.uint16]


class CBinding(Structure):
    """A fine surface that follows a proxy: dm_binding."""

    _fields_ = fields(vertices="n", seeds="n", followed="p", weights="p", rest="p", centre="d3")


def carry(
    library: ctypes.CDLL, rest: Singles, followed: Shorts, weights: Shorts, centre: Floats, motions: Singles
) -> Singles:
    """Return where a surface (n, 3) [m] is.

    Args:
        rest: (n, 3) [m].
        followed, weights: (n, FOLLOWED) what each vertex follows, and how much of 65535.
        centre: (3,) from which shifts are measured [m].
        motions: (m, 16) of that, as `reduction.binding.motions_of` returns them.
    """
    if followed.shape[1] != FOLLOWED or motions.shape[1] != 16:
        raise NativeError("an array has the wrong size")
    given = [np.ascontiguousarray(array) for array in (followed, weights, rest)]
    binding = CBinding(len(rest), len(motions), *(array.ctypes.data for array in given), tuple(centre.tolist()))
    skin, room = np.empty((len(rest), 3), np.float32), np.empty(motions.size + LINE, np.float32)
    begin = -(room.ctypes.data // room.itemsize) % LINE
    room[begin : begin + motions.size] = motions.ravel()  # a motion is a line of the cache, not the halves of two
    code = library.dm_carry(byref(binding), room[begin:].ctypes.data, skin.ctypes.data)
    if code:
        raise NativeError(library.dm_message(code).decode(), code)
    return skin
