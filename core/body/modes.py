"""The lowest modes of a body as a solid, in which it sways, sags and twists as a whole.

They depend only on the shape of the body and on its pins and bones; its material scales their frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints, Shorts, Singles, sums_at
from ..constants import EXACT, ROUNDING, SLACK
from ..mesh.surface import Mesh
from .lattice import Lattice, cells_at, fill, gradients, shares, stiffness, weight

MODES = 20  # number of modes: their sag is that of all modes within 1 %, along the stiffest axis of a block within 10 %
HOLD = 30.0  # stiffness of pins: that of a layer of the body 1 / 30 of a cell thick
BESIDE = 8  # iterated directions in addition to the modes, so that those converge quickly


class Modes(NamedTuple):
    """The mass-normalised modes of a body with Young's modulus 1 Pa and density 1 kg/m3.

    lattice: the lattice whose nodes they move.
    volume: (m,) lumped volume of each node [m3].
    rates: (k,) angular frequencies [rad/s].
    shapes: (k, m, 3) displacement of each node.
    turns: (k, m, 3) rotation of each node: half the curl of the displacement [1/m].
    nodes: (n, 8) nodes that each vertex follows.
    shares: (n, 8) weights of these nodes, reduced to 0 for a held vertex.
    """

    lattice: Lattice
    volume: Floats
    rates: Floats
    shapes: Floats
    turns: Floats
    nodes: Shorts
    shares: Singles


def modes_of(mesh: Mesh, held: Floats, *, bones: Floats | None = None) -> Modes | None:
    """Return the lowest modes of a body; None if all are rigid motions, of four or more parts that nothing holds.

    Args:
        held: (n,) weight of the pin at each vertex, from 0 (free) to 1 (fixed).
        bones: (b, 2, 3) ends of bones [m], which hold the cells that they pass through.
    """
    lattice = fill(mesh)
    nodes, share = shares(lattice, mesh.rest_positions)
    volume, k = weight(lattice), stiffness(lattice)
    _hold(k, nodes, share, HOLD / lattice.sides.mean() * held * mesh.vertex_areas)
    if bones is not None and len(bones):
        step = lattice.sides.mean() / 2
        along = _along(bones, step)
        along = along[cells_at(lattice, along) >= 0]
        _hold(k, *shares(lattice, along), np.full(len(along), HOLD * step))
    scale = 1 / np.sqrt(np.repeat(volume, 3))
    a = k * scale * scale[:, None]
    squares, vectors = _lowest(a, lattice.layers)
    moving = squares > max(ROUNDING * squares[-1], _noise(a))  # a part that nothing holds also moves as a rigid body
    if not moving.any():
        return None
    shapes = (scale[:, None] * vectors[:, moving]).T.reshape(-1, len(volume), 3)
    turns = _turns(lattice, shapes)
    free = (share * (1 - np.clip(held, 0, 1))[:, None]).astype(np.float32)
    return Modes(lattice, volume, np.sqrt(squares[moving]), shapes, turns, nodes.astype(np.uint16), free)


def _along(bones: Floats, step: float) -> Floats:
    """Return points (p, 3) along bones (b, 2, 3), at most a step [m] apart."""
    counts = np.ceil(np.linalg.norm(bones[:, 1] - bones[:, 0], axis=1) / step).astype(int) + 1
    pairs = zip(bones, counts, strict=True)
    return np.concatenate([np.linspace(head, tail, int(count)) for (head, tail), count in pairs])


def _hold(k: Floats, nodes: Ints, share: Floats, springs: Floats) -> None:
    """Add springs (n,) to the stiffness of a lattice, in place; both are divided by Young's modulus [m]."""
    at = np.flatnonzero(springs)
    each = springs[at, None, None] * share[at][:, :, None] * share[at][:, None, :]
    for axis in range(3):
        freedom = 3 * nodes[at] + axis
        np.add.at(k, (freedom[:, :, None], freedom[:, None, :]), each)


def _lowest(a: Floats, layers: Ints) -> tuple[Floats, Floats]:
    """Return the lowest eigenvalues of a symmetric matrix in ascending order, and their vectors in columns.

    The method is inverse iteration of a subspace, until no eigenvalue changes visibly.

    Args:
        layers: index of the first unknown of each layer, and the end; each layer is coupled to adjacent layers only.
    """
    solve = _solver(a + _noise(a) * np.eye(len(a)), layers)  # `a` is singular if a part is free
    found = np.random.default_rng(0).normal(size=(len(a), min(MODES + BESIDE, len(a))))
    squares, before = np.zeros(1), np.full(1, np.inf)
    while np.abs(squares - before).max() > max(SLACK * squares[-1], _noise(a)):
        found, before = np.linalg.qr(solve(found))[0], squares
        squares, turn = np.linalg.eigh(found.T @ a @ found)
        squares = squares[:MODES]
    return squares, (found @ turn)[:, :MODES]


def _noise(a: Floats) -> float:
    """Return the size of an eigenvalue that may be rounding of 0."""
    return EXACT * float(np.trace(a)) / len(a)


def _solver(a: Floats, layers: Ints) -> Callable[[Floats], Floats]:
    """Return a function of b that gives the solution x of a x = b, by block elimination layer by layer."""
    parts = [slice(*ends) for ends in pairwise(layers)]
    inverses, beside = [np.linalg.inv(a[parts[0], parts[0]])], [a[here, there] for here, there in pairwise(parts)]
    for part, to in zip(parts[1:], beside, strict=True):
        inverses.append(np.linalg.inv(a[part, part] - to.T @ inverses[-1] @ to))

    def solve(b: Floats) -> Floats:
        x = b.copy()
        for (before, here), to, inverse in zip(pairwise(parts), beside, inverses, strict=False):
            x[here] -= to.T @ (inverse @ x[before])
        x[parts[-1]] = inverses[-1] @ x[parts[-1]]
        for (here, after), to, inverse in reversed(list(zip(pairwise(parts), beside, inverses, strict=False))):
            x[here] = inverse @ (x[here] - to @ x[after])
        return x

    return solve


def _turns(lattice: Lattice, shapes: Floats) -> Floats:
    """Return half the curl (k, m, 3) of displacements (k, m, 3), averaged over the cells round each node."""
    slope = gradients(np.full(3, 0.5)) / lattice.sides
    inside = np.einsum("ca,kxcb->kxab", slope, shapes[:, lattice.cells])
    curl = np.stack([inside[..., i - 2, i - 1] - inside[..., i - 1, i - 2] for i in range(3)], axis=-1) / 2
    cells, parts = lattice.cells.ravel(), np.repeat(lattice.filled[:, None, None] * curl.transpose(1, 0, 2), 8, axis=0)
    flat = parts.reshape(len(cells), -1)
    total = np.stack([sums_at(cells, column, len(lattice.nodes)) for column in flat.T])
    count = sums_at(cells, np.repeat(lattice.filled, 8), len(lattice.nodes))
    return (total / count).reshape(len(shapes), 3, -1).transpose(0, 2, 1)
