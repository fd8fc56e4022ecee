"""The call that carries a fine surface by the motion of a proxy, and its structure of dimple.h."""

from __future__ import annotations

import ctypes
from ctypes import Structure, byref

import numpy as np
import numpy.typing as npt

from ..base import Singles
from .body import NativeError
from .definition import fields


class CBinding(Structure):
    """A fine surface that follows a proxy: dm_binding."""

    _fields_ = fields(vertices="n", seeds="n", each="n", followed="p", weights="p", lever="p", rest="p")


def carry(
    library: ctypes.CDLL,
    rest: Singles,
    followed: npt.NDArray[np.uint16],
    weights: Singles,
    lever: Singles,
    motions: Singles,
) -> Singles:
    """Return where a surface (n, 3) [m] is.

    Args:
        rest, lever: (n, 3) [m].
        followed, weights: (n, k) what each vertex follows.
        motions: (m, 12) of that: a shift [m] and a gradient by rows.
    """
    given = [np.ascontiguousarray(array) for array in (followed, weights, lever, rest)]
    binding = CBinding(len(rest), len(motions), followed.shape[1], *(array.ctypes.data for array in given))
    motions, skin = np.ascontiguousarray(motions), np.empty((len(rest), 3), np.float32)
    code = library.dm_carry(byref(binding), motions.ctypes.data, skin.ctypes.data)
    if code:
        raise NativeError(library.dm_message(code).decode(), code)
    return skin
