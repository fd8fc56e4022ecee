"""The call that carries a fine surface along with a proxy, its arguments, and its structure of dimple.h."""

from __future__ import annotations

import ctypes
from ctypes import Structure, byref
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ..base import Floats, Ints, Shorts, Singles
from ..constants import LANES
from .body import NativeError, call
from .definition import Arrays, fields

Values = TypeVar("Values", Floats, Singles)


class CBinding(Structure):
    """A fine surface that follows a proxy: dm_binding."""

    _fields_ = fields(
        vertices="n", entries="n", first="p", followed="p", weights="p", places="p", seeds="n", coarse_rest="p",
        triangles="n", corners="p", arms="n", ends="p", starts="p", spread="p", upright="p", centre="d3",
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Binding:
    """The data by which a coarse mesh of m vertices carries a fine surface of n.

    Each of g groups of eight consecutive vertices shares one list of the coarse vertices that any of them follows.

    vertices: n.
    first: (g + 1,) start of the list of each group.
    followed: (p,) coarse vertices in all lists.
    weights: (p, 8) weights of their motions; those of a vertex add up to `reduction.binding.WHOLE`.
    places: (g, 6, 8) [m] x, y and z at rest, and the vector that multiplies the gradient.
    centre: (3,) point from which shifts are measured [m].
    coarse_rest: (m, 3) rest positions of the coarse mesh [m], and corners: (t, 3) of its triangles.
    arms: (e, 2) directed edges of the coarse mesh, sorted by first end, and starts: (m + 1,) start of each vertex's.
    spread: (e, 3) rows that convert the motion along an edge into a gradient [1/m].
    upright: (m, 3) rows that convert the change of a normal into a gradient.
    """

    vertices: int
    first: Ints
    followed: Shorts
    weights: Shorts
    places: Singles
    centre: Floats
    coarse_rest: Floats
    corners: Ints
    arms: Ints
    starts: Ints
    spread: Floats
    upright: Floats

    @property
    def rest(self) -> Singles:
        """Return the rest positions (n, 3) of the fine surface [m]."""
        return in_rows(self.places[:, :3], self.vertices)


def in_rows(eights: Values, vertices: int) -> Values:
    """Return values (g, c, 8) of vertices in groups of eight as rows (n, c)."""
    return eights.transpose(0, 2, 1).reshape(-1, eights.shape[1])[:vertices]


def carry(library: ctypes.CDLL, binding: Binding, positions: Floats) -> tuple[Singles, Singles]:
    """Return the positions (n, 3) [m] of the carried surface, and the motions (m, 12) that carried it.

    Args:
        positions: of the coarse mesh, (3, m) [m].
    """
    skin = np.empty((binding.vertices, 3), np.float32)
    motions = np.empty((len(binding.coarse_rest), 12), np.float32)
    with Arrays() as arrays:
        given = _given(binding, positions, arrays)
        at = arrays.double(positions)
        call(library, "dm_carry", byref(given), at, motions.ctypes.data, skin.ctypes.data)
    return skin, motions


def carry_by_nodes(library: ctypes.CDLL, by: Shorts, shares: Singles, values: Floats) -> Singles:
    """Interpolate values (m, 3) of nodes to vertices (n, 3), each carried by eight nodes (n, 8) with shares (n, 8)."""
    carried, padded = np.empty((len(by), 3), np.float32), np.empty((len(values), 4), np.float32)
    if by.shape != shares.shape or by.shape[1:] != (8,) or values.shape[1:] != (3,):
        raise NativeError("an array has the wrong size")
    padded[:, :3] = values
    with Arrays() as arrays:
        given = arrays.of(by, np.uint16), arrays.of(shares, np.float32), padded.ctypes.data, carried.ctypes.data
        call(library, "dm_carry_by_nodes", len(by), len(values), *given)
    return carried


def _given(binding: Binding, positions: Floats, arrays: Arrays) -> CBinding:
    n, m, e, t = binding.vertices, len(binding.coarse_rest), len(binding.arms), len(binding.corners)
    eights, entries = -(-n // LANES), len(binding.followed)
    shapes = {
        "first": (eights + 1,), "weights": (entries, LANES), "places": (eights, 6, LANES), "starts": (m + 1,),
        "spread": (e, 3), "upright": (m, 3), "corners": (t, 3), "arms": (e, 2), "centre": (3,),
    }  # fmt: skip
    if positions.shape != (3, m) or any(getattr(binding, name).shape != shape for name, shape in shapes.items()):
        raise NativeError("an array has the wrong size")
    return CBinding(
        n, entries, arrays.index(binding.first), arrays.of(binding.followed, np.uint16),
        arrays.of(binding.weights, np.uint16), arrays.of(binding.places, np.float32),
        m, arrays.double(binding.coarse_rest), t, arrays.index(binding.corners),
        e, arrays.index(binding.arms[:, 1]), arrays.index(binding.starts),
        arrays.double(binding.spread), arrays.double(binding.upright), tuple(binding.centre.tolist()),
    )  # fmt: skip
