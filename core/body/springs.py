"""Springs along the edges, with dashpots beside them.

    E = sum k (|l| - l0)^2 / 2,   f_i = sum_j k (1 - l0 / |l|) l_ij,   l_ij = x_j - x_i

and a dashpot c along the edge, as a ratio of the critical damping of the two vertices it joins.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats, Ints, sums_at
from ..mesh.rings import Rings
from ..mesh.surface import Mesh

_TINY = 1e-30


@dataclass(frozen=True, slots=True, kw_only=True)
class Springs:
    """Hold springs.

    pairs: (m, 2), the mesh's, then bend springs.  rest_lengths [m], stiffness [N/m], damping [N s/m]: (m,).
    ring_*: the same, slot by slot (w, n).  rings: the mesh's, bend springs among the loose ones.
    """

    pairs: Ints
    rest_lengths: Floats
    stiffness: Floats
    damping: Floats
    rings: Rings
    ring_rest: Floats
    ring_stiffness: Floats
    ring_damping: Floats


def build_springs(mesh: Mesh, stiffness: Floats, damping: Floats, bend: Ints | None = None) -> Springs:
    """Lay per-spring constants (m,) out along the one-rings.

    Args:
        stiffness, damping: of the mesh's springs, then of the bend springs.
        bend: (b, 2) pairs of vertices joined beside the mesh's springs.
    """
    rings, pairs, lengths = mesh.rings, mesh.springs, mesh.rest_lengths
    if bend is not None and len(bend):
        extra = np.arange(len(pairs), len(pairs) + len(bend))
        rings = replace(
            rings,
            loose_springs=np.concatenate([rings.loose_springs, extra]),
            loose_ends=np.concatenate([rings.loose_ends, np.ones((len(bend), 2), bool)]),
        )
        ends = mesh.rest_positions[bend]
        pairs = np.concatenate([pairs, bend])
        lengths = np.concatenate([lengths, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)])
    slots = rings.springs
    used = slots >= 0
    return Springs(
        pairs=pairs, rest_lengths=lengths, stiffness=stiffness, damping=damping, rings=rings,
        ring_rest=np.where(used, lengths[slots], 0.0),
        ring_stiffness=np.where(used, stiffness[slots], 0.0),
        ring_damping=np.where(used, damping[slots], 0.0),
    )  # fmt: skip


def bend_pairs(mesh: Mesh) -> tuple[Ints, Ints]:
    """Return the corners (b, 2) opposite each edge that two triangles share, and that edge (b,). Source: Provot."""
    shared = np.flatnonzero(mesh.spring_triangles[:, 0] != mesh.spring_triangles[:, 1])
    # a triangle's corners less the two ends of the edge
    across = mesh.triangles[mesh.spring_triangles[shared]].sum(axis=2) - mesh.springs[shared].sum(axis=1)[:, None]
    apart = across[:, 0] != across[:, 1]
    return across[apart], shared[apart]


def membrane_stiffness(mesh: Mesh, k: Floats) -> Floats:
    """Turn a material's k [N/m] into one constant per spring, (m,) [N/m].

    k_e = k (A_1 + A_2) / (l^2 sqrt(3) / 2): the sheet's stiffness depends on neither resolution nor
    triangulation, and k_e = k where the triangles are equilateral. Source: Van Gelder 1998.
    """
    length = np.maximum(mesh.rest_lengths, 1e-9 * mesh.size)
    return k * mesh.spring_areas / (length**2 * np.sqrt(3) / 2)


def around(rings: Rings, x: Floats) -> Floats:
    """Gather the vectors (3, w, n) from each vertex to the neighbours round it."""
    vectors = np.empty((3, *rings.neighbours.shape))
    for c in range(3):
        np.take(x[c], rings.neighbours, out=vectors[c], mode="clip")  # the fast way: no check of bounds, no buffer
        vectors[c] -= x[c]
    return vectors


def energy(law: Springs, x: Floats) -> float:
    """Return the energy [J] at positions (3, n) [m]."""
    stretch = np.linalg.norm(x[:, law.pairs[:, 1]] - x[:, law.pairs[:, 0]], axis=0) - law.rest_lengths
    return float(law.stiffness @ stretch**2) / 2


def force(law: Springs, x: Floats, v: Floats | None = None, arms: Floats | None = None) -> Floats:
    """Return the forces (3, n) [N] of springs and, given velocities (3, n) [m/s], dashpots.

    Args:
        arms: `around(law.rings, x)` where the caller has it already.
    """
    d = around(law.rings, x) if arms is None else arms
    square = np.maximum(np.einsum("csn,csn->sn", d, d), _TINY)
    tension = np.sqrt(square)
    np.divide(law.ring_rest, tension, out=tension)
    np.subtract(1, tension, out=tension)
    tension *= law.ring_stiffness
    if v is not None:
        growth = np.einsum("csn,csn->sn", d, around(law.rings, v))
        growth *= law.ring_damping
        growth /= square
        tension += growth
    f = np.einsum("sn,csn->cn", tension, d)
    _add_loose(law, f, x, v)
    return f


def row_bounds(law: Springs, n: int) -> tuple[Floats, Floats]:
    """Return (n,) each twice the stiffness [N/m] and twice the damping [N s/m] met in a vertex (Gershgorin)."""
    both = np.concatenate([law.pairs[:, 0], law.pairs[:, 1]])
    return (
        2 * sums_at(both, np.tile(law.stiffness, 2), n),
        2 * sums_at(both, np.tile(law.damping, 2), n),
    )


def _add_loose(law: Springs, f: Floats, x: Floats, v: Floats | None) -> None:
    loose = law.rings.loose_springs
    if not len(loose):
        return
    i, j = law.pairs[loose].T
    d = x[:, j] - x[:, i]
    square = np.maximum((d * d).sum(axis=0), _TINY)
    tension = law.stiffness[loose] * (1 - law.rest_lengths[loose] / np.sqrt(square))
    if v is not None:
        tension += law.damping[loose] * (d * (v[:, j] - v[:, i])).sum(axis=0) / square
    pull, (at_i, at_j) = tension * d, law.rings.loose_ends.T
    for c in range(3):
        f[c] += sums_at(i[at_i], pull[c, at_i], x.shape[1]) - sums_at(j[at_j], pull[c, at_j], x.shape[1])
