"""The binding of a fine surface to the coarse mesh of a proxy, whose motion it follows."""

from __future__ import annotations

import numpy as np

from .. import native
from ..base import Floats, Ints, Shorts, Singles, distinct, row_parts, sums_at
from ..constants import FOLLOWED, LANES
from ..mesh.surface import Mesh
from ..native.carry import Binding, Values, in_rows
from .cells import vertex_normals

WHOLE = int(np.iinfo(np.uint16).max)  # sum of the weights of a vertex, and most vertices of a proxy


def bind(rest: Floats, coarse: Mesh, place: Floats, seeds: Ints, cells: Ints) -> Binding:
    """Bind a fine surface to a coarse mesh.

    Args:
        rest: (n, 3) rest positions of the fine surface [m].
        place: (n, 6) its vertices in the space of the cells [m].
        seeds: (m,) the fine vertex at which each coarse vertex lies.
        cells: (n,) the coarse vertex to whose cell each fine vertex belongs.
    """
    lists = _followed(coarse, place, seeds, cells)
    centre, middle = rest.mean(axis=0), sums_of(*lists, coarse.rest_positions)
    places = np.zeros((len(middle), 6, LANES), np.float32)
    for c in range(3):
        at = np.append(rest[:, c], np.zeros(-len(rest) % LANES)).reshape(-1, LANES)
        places[:, c], places[:, 3 + c] = at, 2 * at - centre[c] - middle[:, c] / WHOLE
    arms, spread, upright = _gradient(coarse)
    return Binding(
        vertices=len(rest), first=lists[0], followed=lists[1], weights=lists[2], places=places, centre=centre,
        coarse_rest=coarse.rest_positions, corners=coarse.triangles, arms=arms,
        starts=np.searchsorted(arms[:, 0], np.arange(len(seeds) + 1)), spread=spread, upright=upright,
    )  # fmt: skip


def carry(binding: Binding, positions: Floats) -> Singles:
    """Return the fine positions (n, 3) [m] for coarse positions (3, m) [m]; at rest they are exact to the bit.

    F_j is the deformation gradient that best fits the one-ring of seed j and its normal. Seed j alone would move a fine
    point X to x_j + (F_j + F) (X - X_j) / 2, where F is the gradient at X: exact for rigid motions and for parabolic
    dents. A vertex takes the weighted mean over the seeds that it follows, for F too; the weights are smooth functions
    of the place, so no facets show.
    """
    return native.carry(native.library(), binding, positions)[0]


def blend(binding: Binding, values: Floats) -> Floats:
    """Return the weighted mean (n, c) of values (m, c) at the coarse vertices that each fine vertex follows."""
    sums = sums_of(binding.first, binding.followed, binding.weights, values)
    return np.asarray(in_rows(sums, binding.vertices) / WHOLE, np.float64)


def sums_of(first: Ints, followed: Shorts, weights: Shorts, values: Values) -> Values:
    """Return the weighted sums (g, c, 8) of values (m, c) at the coarse vertices that each fine vertex follows."""
    count = np.diff(first)
    sums = np.zeros((len(count), values.shape[1], LANES), values.dtype)
    for part in row_parts(len(count), LANES):
        least = count[part].min()
        for k in range(count[part].max()):
            longer = np.flatnonzero(count[part] > k) if k >= least else slice(None)
            at = first[:-1][part][longer] + k
            ways = np.take(values, followed[at], axis=0)[:, :, None]
            sums[part][longer] += ways * weights[at][:, None].astype(values.dtype)
    return sums


def _followed(mesh: Mesh, place: Floats, seeds: Ints, cells: Ints) -> tuple[Ints, Shorts, Shorts]:
    """Return the lists of the seeds that each fine vertex follows and of their weights, whose sum is WHOLE.

    These are the nearest seeds in two rings round its own, weighted by (1 - (d / D)^2)^2, where D is the distance of
    the first seed left out: so the weight and its slope are 0 where a seed enters or leaves the list.
    """
    around = _two_rings(mesh.springs, len(seeds))
    return native.follow_cells(native.library(), place, seeds, cells, around)


def _two_rings(edges: Ints, m: int) -> Ints:
    """Return the vertices (m, w) within two edges of each, itself included, in ascending order; -1 fills each row."""
    (i, j), itself = edges.T, np.arange(m) * (m + 1)
    near, far = np.divmod(distinct(np.concatenate([i * m + j, j * m + i, itself])), m)
    start = np.searchsorted(near, np.arange(m + 1))
    count = np.diff(start)[far]  # insert each neighbour's own row of neighbours
    at = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(start[far], count)
    first, second = np.divmod(distinct(np.repeat(near, count) * m + far[at]), m)
    begin = np.searchsorted(first, np.arange(m))
    column = np.arange(len(first)) - begin[first]
    around = np.full((m, max(FOLLOWED + 1, int(column.max()) + 1)), -1)
    around[first, column] = second
    return around


def _gradient(mesh: Mesh) -> tuple[Ints, Floats, Floats]:
    """Return directed edges (e, 2), and rows (e, 3) and (m, 3) such that F - 1 at vertex i is

        sum over its edges of (u_j - u_i) row_ij^T + (change of the normal) row_i^T.

    F minimises sum |F e - e'|^2 / |e|^2 + s |F n - n'|^2: the rows are e / |e|^2 and s n times the inverse of
    sum e e^T / |e|^2 + s n n^T. s is half the number of edges: the weight that they give each tangential direction.
    """
    x, m = mesh.rest_positions, len(mesh.rest_positions)
    arms = np.concatenate([mesh.springs, mesh.springs[:, ::-1]])
    arms = arms[np.argsort(arms[:, 0], kind="stable")]
    i, j = arms.T
    edge = x[j] - x[i]
    row = edge / (edge**2).sum(axis=1)[:, None]
    normals = vertex_normals(mesh.triangles, x)
    s = np.bincount(i, minlength=m) / 2
    moment = s[:, None, None] * normals[:, :, None] * normals[:, None, :]
    outer = (edge[:, :, None] * row[:, None, :]).reshape(-1, 9)
    for c in range(9):
        moment.reshape(-1, 9)[:, c] += sums_at(i, outer[:, c], m)
    inverse = np.linalg.pinv(moment, rcond=1e-3, hermitian=True)
    return arms, np.einsum("ec,ecd->ed", row, inverse[i]), s[:, None] * np.einsum("mc,mcd->md", normals, inverse)
