"""The lowest modes of a body as a solid: how it sways, sags and twists as a whole.

Only the shape of the body and what holds it decide them; its material sets how fast they swing.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints, Shorts, Singles, sums_at
from ..mesh.surface import Mesh
from .lattice import Lattice, cells_at, fill, gradients, shares, stiffness, weight

MODES = 20  # of them: they sag as all do within 1 %, along the stiffest axis of a block within 10 %
HOLD = 30.0  # pins hold as stiffly as a layer of the body that is a 30th of a cell thick
RIGID = 1e-6  # of the stiffest mode: what resists less is a part that nothing holds, and moves whole
ROUNDS = 8  # of inverse iteration, which gains the ratio of the first left out to the wanted one each round
BESIDE = 8  # more directions than modes, so that this ratio is large


class Modes(NamedTuple):
    """The modes of a body of Young's modulus 1 Pa and density 1 kg/m3, normal to its mass.

    lattice: what they move.
    volume: (m,) that each node stands for [m3].
    rates: (k,) angular frequencies [rad/s].
    shapes: (k, m, 3) displacement of each node.
    turns: (k, m, 3) rotation of each node: half the curl of the displacement [1/m].
    nodes: (n, 8) that carry each vertex, and
    shares: (n, 8) how much of each, 0 where the vertex is held.
    """

    lattice: Lattice
    volume: Floats
    rates: Floats
    shapes: Floats
    turns: Floats
    nodes: Shorts
    shares: Singles


def modes_of(
    mesh: Mesh, positions: Floats, held: Floats, *, bones: Floats | None = None, most: int = MODES
) -> Modes:
    """Return the lowest modes of a body.

    Args:
        positions: (n, 3) of its vertices [m].
        held: (n,) how firmly each is held: 1 does not move, 0 is free.
        bones: (b, 2, 3) ends of bones [m]: they hold the cells that they pass through.
    """
    lattice = fill(mesh, positions)
    nodes, share = shares(lattice, positions)
    volume, k = weight(lattice), stiffness(lattice)
    _hold(k, nodes, share, HOLD / lattice.sides.mean() * held * mesh.vertex_areas)
    if bones is not None and len(bones):
        step = lattice.sides.mean() / 2
        along = _along(bones, step)
        along = along[cells_at(lattice, along) >= 0]
        _hold(k, *shares(lattice, along), np.full(len(along), HOLD * step))
    scale = 1 / np.sqrt(np.repeat(volume, 3))
    squares, vectors = _lowest(k * scale * scale[:, None], lattice.layers, most)
    moving = squares > RIGID * squares[-1]
    shapes = (scale[:, None] * vectors[:, moving]).T.reshape(-1, len(volume), 3)
    turns = _turns(lattice, shapes)
    free = (share * (1 - np.clip(held, 0, 1))[:, None]).astype(np.float32)
    return Modes(lattice, volume, np.sqrt(squares[moving]), shapes, turns, nodes.astype(np.uint16), free)


def _along(bones: Floats, step: float) -> Floats:
    """Return points (p, 3) along bones (b, 2, 3), no farther apart than a step [m]."""
    counts = np.ceil(np.linalg.norm(bones[:, 1] - bones[:, 0], axis=1) / step).astype(int) + 1
    pairs = zip(bones, counts, strict=True)
    return np.concatenate([np.linspace(head, tail, int(count)) for (head, tail), count in pairs])


def _hold(k: Floats, nodes: Ints, share: Floats, springs: Floats) -> None:
    """Add springs (n,) [m] at the vertices to the stiffness of a lattice."""
    at = np.flatnonzero(springs)
    each = springs[at, None, None] * share[at][:, :, None] * share[at][:, None, :]
    for axis in range(3):
        freedom = 3 * nodes[at] + axis
        np.add.at(k, (freedom[:, :, None], freedom[:, None, :]), each)


def _lowest(a: Floats, layers: Ints, most: int) -> tuple[Floats, Floats]:
    """Return the lowest eigenvalues of a symmetric matrix, rising, and their vectors in columns: by inverse iteration.

    Args:
        layers: where each layer of unknowns begins, and the last ends; each resists only those beside it.
    """
    solve = _solver(a + 1e-9 * np.trace(a) / len(a) * np.eye(len(a)), layers)  # what nothing holds has a mode of 0
    found = np.random.default_rng(0).normal(size=(len(a), min(most + BESIDE, len(a))))
    for _ in range(ROUNDS):
        found = np.linalg.qr(solve(found))[0]
    squares, turn = np.linalg.eigh(found.T @ a @ found)
    return squares[:most], (found @ turn)[:, :most]


def _solver(a: Floats, layers: Ints) -> Callable[[Floats], Floats]:
    """Return what solves a x = b by eliminating layer after layer."""
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
    """Return half the curl (k, m, 3) of displacements (k, m, 3): the mean over the cells round each node."""
    slope = gradients(np.full(3, 0.5)) / lattice.sides
    inside = np.einsum("ca,kxcb->kxab", slope, shapes[:, lattice.cells])
    curl = np.stack([inside[..., i - 2, i - 1] - inside[..., i - 1, i - 2] for i in range(3)], axis=-1) / 2
    cells, parts = lattice.cells.ravel(), np.repeat(lattice.filled[:, None, None] * curl.transpose(1, 0, 2), 8, axis=0)
    flat = parts.reshape(len(cells), -1)
    total = np.stack([sums_at(cells, column, len(lattice.nodes)) for column in flat.T])
    count = sums_at(cells, np.repeat(lattice.filled, 8), len(lattice.nodes))
    return (total / count).reshape(len(shapes), 3, -1).transpose(0, 2, 1)
