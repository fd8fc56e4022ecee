"""A coarse lattice of nearly cubic cells that fills a body: the volumes and the stiffness of a solid of that shape.

A cell is weighted by its share inside the body. Sources: Hughes 1980 (mean dilatation, so that a nearly incompressible
cell does not lock); the finite cell method (Parvizian, Duester and Rank 2007) for partly filled cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints, sums_at
from ..mesh.surface import Mesh, capped

CELLS = 400  # approximate number of cells of a body: more change its first frequencies by only a few per cent
SAMPLES = 4  # sample points along each side of a cell, to determine its share inside
POISSON = 0.49  # Poisson's ratio of soft solids (rubber, jelly, flesh), which hardly change their volume
CORNERS = np.array([(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)])


class Lattice(NamedTuple):
    """Cells that fill a body and span its bounding box exactly.

    nodes: (m, 3) corners of the cells [m].
    cells: (c, 8) nodes of each cell, in the order of CORNERS.
    filled: (c,) share of each cell that is inside the body.
    sides: (3,) sides of a cell [m].
    layers: index of the first unknown (three a node) of each layer of nodes across the longest axis, and the end.
    """

    nodes: Floats
    cells: Ints
    filled: Floats
    sides: Floats
    layers: Ints


def fill(mesh: Mesh) -> Lattice:
    """Fill a body at rest with cells."""
    positions = mesh.rest_positions
    low, extent = positions.min(axis=0), np.ptp(positions, axis=0)
    count = np.maximum(np.round(extent / (mesh.volume / CELLS) ** (1 / 3)), 1).astype(int)
    sides = extent / count
    share = _inside(capped(mesh), low, sides / SAMPLES, SAMPLES * count)
    share = share.reshape(count[0], SAMPLES, count[1], SAMPLES, count[2], SAMPLES).mean(axis=(1, 3, 5))
    at = tuple(np.clip(_cell_of(positions, low, sides), 0, count - 1).T)
    share[at] = np.maximum(share[at], SAMPLES**-3)  # a cell with vertices is a part of the body
    kept = np.argwhere(share > 0)
    order = np.argsort(-count)  # layers across the longest axis are the smallest
    corners = (kept[:, None] + CORNERS).reshape(-1, 3)[:, order]
    number, inverse = np.unique(corners, axis=0, return_inverse=True)
    layers = np.append(3 * np.unique(number[:, 0], return_index=True)[1], 3 * len(number))
    nodes = low + sides * number[:, np.argsort(order)]
    return Lattice(nodes, inverse.reshape(-1, 8), share[tuple(kept.T)], sides, layers)


def _inside(surface: tuple[Floats, Ints], low: Floats, step: Floats, count: Ints) -> Floats:
    """Return 1.0 for points of a grid inside a closed surface, else 0.0.

    Each column of points is cut by the triangles above and below it; a point is inside if more of those above it face
    up than down.
    """
    points, triangles = surface
    at = (points - low) / step - 0.5 - 1e-4 * np.array([np.pi, np.e, 0])  # no column passes through a vertex
    a, b, c = at[triangles].transpose(1, 0, 2)
    first = np.clip(np.ceil(np.minimum(np.minimum(a, b), c)[:, :2]), 0, None).astype(int)
    last = np.minimum(np.floor(np.maximum(np.maximum(a, b), c)[:, :2]), count[:2] - 1).astype(int)
    wide = np.maximum(last - first + 1, 0)
    many = wide.prod(axis=1)
    t = np.repeat(np.arange(len(triangles)), many)
    number = np.arange(len(t)) - np.repeat(np.cumsum(many) - many, many)
    x, y = first[t, 0] + number // wide[t, 1], first[t, 1] + number % wide[t, 1]

    def turn(p: Floats, q: Floats) -> Floats:
        return (q[t, 0] - p[t, 0]) * (y - p[t, 1]) - (q[t, 1] - p[t, 1]) * (x - p[t, 0])

    ab, bc, ca = turn(a, b), turn(b, c), turn(c, a)
    total = ab + bc + ca
    cut = ((ab > 0) & (bc > 0) & (ca > 0)) | ((ab < 0) & (bc < 0) & (ca < 0))
    z = (bc * a[t, 2] + ca * b[t, 2] + ab * c[t, 2])[cut] / total[cut]
    below = np.clip(np.ceil(z), 0, count[2]).astype(int)  # the number of points under each cut
    cuts = np.zeros((count[0], count[1], count[2] + 1))
    np.add.at(cuts, (x[cut], y[cut], below), np.sign(total[cut]))
    turns = cuts[:, :, ::-1].cumsum(axis=2)[:, :, ::-1][:, :, 1:]
    return (turns > 0.5).astype(float)


def stiffness(lattice: Lattice) -> Floats:
    """Return the stiffness (3 m, 3 m) of a lattice divided by Young's modulus [m]."""
    size = 3 * len(lattice.nodes)
    unit = _cell_stiffness(lattice.sides)
    freedoms = (3 * lattice.cells[:, :, None] + np.arange(3)).reshape(-1, 24)
    at = freedoms[:, :, None] * size + freedoms[:, None, :]
    return sums_at(at.ravel(), (lattice.filled[:, None, None] * unit).ravel(), size * size).reshape(size, size)


def weight(lattice: Lattice) -> Floats:
    """Return the lumped volume (m,) of each node [m3]."""
    each = np.repeat(lattice.filled * lattice.sides.prod() / 8, 8)
    return sums_at(lattice.cells.ravel(), each, len(lattice.nodes))


def _cell_stiffness(sides: Floats) -> Floats:
    """Return the stiffness (24, 24) of a cell divided by Young's modulus [m]."""
    lame, shear = POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), 1 / (2 + 2 * POISSON)
    points = (CORNERS - 0.5) / np.sqrt(3)  # Gauss points
    slopes = np.stack([gradients(point + 0.5) for point in points]) / sides
    mean = slopes.mean(axis=0)
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    total = np.zeros((24, 24))
    for slope in slopes:
        strain = np.zeros((6, 8, 3))
        for i in range(3):
            strain[i, :, i] = slope[:, i]
            strain[3 + i, :, (i + 1) % 3], strain[3 + i, :, i] = slope[:, i], slope[:, (i + 1) % 3]
        strain[:3] += (mean - slope)[None] / 3
        flat = strain.reshape(6, 24)
        total += sides.prod() / 8 * flat.T @ law @ flat
    return total


def gradients(at: Floats) -> Floats:
    """Return the gradients (8, 3) of the shape functions of the corners of a unit cube at a place (3,) in it."""
    parts = np.where(CORNERS == 1, at, 1 - at)
    signs = np.where(CORNERS == 1, 1.0, -1.0)
    return np.stack([signs[:, i] * np.delete(parts, i, axis=1).prod(axis=1) for i in range(3)], axis=1)


def shares(lattice: Lattice, positions: Floats) -> tuple[Ints, Floats]:
    """Return the eight nodes (n, 8) of the cell at each place (n, 3) [m], and their trilinear weights (n, 8)."""
    cell = cells_at(lattice, positions)
    origin = lattice.nodes[lattice.cells[cell, 0]]
    local = np.clip((positions - origin) / lattice.sides, 0, 1)[:, None]
    return lattice.cells[cell], np.where(CORNERS == 1, local, 1 - local).prod(axis=2)


def cells_at(lattice: Lattice, positions: Floats) -> Ints:
    """Return the cell (n,) in which each place (n, 3) [m] lies, -1 outside all cells."""
    origin = lattice.nodes[lattice.cells[:, 0]]
    low = lattice.nodes.min(axis=0)
    count = np.round(np.ptp(lattice.nodes, axis=0) / lattice.sides).astype(int)
    grid = np.full(count, -1)
    grid[tuple(np.round((origin - low) / lattice.sides).astype(int).T)] = np.arange(len(origin))
    at = _cell_of(positions, low, lattice.sides)
    found: Ints = grid[tuple(np.clip(at, 0, count - 1).T)]
    return np.where(((at >= 0) & (at < count)).all(axis=1), found, -1)


def _cell_of(positions: Floats, low: Floats, sides: Floats) -> Ints:
    """Return the index (n, 3) of the cell of the grid from `low` on in which each place (n, 3) [m] lies."""
    index: Ints = np.floor((positions - low) / sides * (1 - 1e-12)).astype(np.int64)  # a far side belongs to its cell
    return index
