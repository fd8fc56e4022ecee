"""How a proxy carries a fine surface along, as the native core does it."""

from __future__ import annotations

import numpy as np

from core.base import Floats, Singles
from core.constants import LANES
from core.native.carry import Binding, in_rows
from core.reduction.binding import WHOLE, sums_of
from core.reduction.cells import vertex_normals


def motions_of(binding: Binding, positions: Floats) -> Singles:
    """Return the motion (m, 12) of each coarse vertex, over WHOLE.

    Half of its shift [m], and the columns of half of its gradient.
    """
    rest, u = binding.coarse_rest, positions.T - binding.coarse_rest
    i, j = binding.arms.T
    turned = vertex_normals(binding.corners, positions.T) - vertex_normals(binding.corners, rest)
    along, stretched = np.take(u, j, axis=0) - np.take(u, i, axis=0), np.empty((len(i), 9))
    for c in range(3):  # of the gradient, by columns
        np.multiply(binding.spread, along[:, c, None], out=stretched[:, c::3])
    gradient = np.einsum("md,mc->mdc", binding.upright, turned)
    gradient += np.add.reduceat(stretched, binding.starts[:-1]).reshape(-1, 3, 3)
    shift = u - np.einsum("mdc,md->mc", gradient, rest - binding.centre) / 2
    return (np.concatenate([shift, gradient.reshape(-1, 9) / 2], axis=1) / WHOLE).astype(np.float32)


def carry(binding: Binding, motions: Singles) -> Singles:
    """Return the surface (n, 3) [m] that some motions (m, 12) make."""
    way = sums_of(binding.first, binding.followed, binding.weights, motions)
    gradient = way[:, 3:].reshape(-1, 3, 3, LANES)
    moved = binding.places[:, :3] + (way[:, :3] + np.einsum("gdci,gdi->gci", gradient, binding.places[:, 3:]))
    return in_rows(moved, binding.vertices)
