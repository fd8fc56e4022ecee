"""Springs along the edges, with dashpots beside them.

    E = sum k (|l| - l0)^2 / 2,   f_i = sum_j k (1 - l0 / |l|) l_ij,   l_ij = x_j - x_i

and a dashpot c along the edge, as a ratio of the critical damping of the two vertices it joins.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import Floats, Ints, sums_at
from ..constants import TINY
from ..mesh.rings import Rings
from ..mesh.surface import Mesh


@dataclass(frozen=True, kw_only=True)
class Springs:
    """The springs of a mesh.

    pairs: (m, 2) vertices at their ends.
    rest_lengths: (m,) [m].
    stiffness: (m,) [N/m].
    damping: (m,) of the dashpots beside them [N s/m].
    rings: the mesh's one-rings.
    """

    pairs: Ints
    rest_lengths: Floats
    stiffness: Floats
    damping: Floats
    rings: Rings

    @cached_property
    def in_slots(self) -> tuple[Floats, Floats]:
        """Return lengths at rest and stiffness slot by slot (w, n), 0 in padded slots: for numpy alone."""
        return self._slots(self.rest_lengths), self._slots(self.stiffness)

    @cached_property
    def damping_in_slots(self) -> Floats:
        """Return the damping slot by slot (w, n), 0 in padded slots."""
        return self._slots(self.damping)

    def _slots(self, values: Floats) -> Floats:
        at = self.rings.springs
        found = values.take(at, mode="clip")
        found[at < 0] = 0.0
        return found


def build_springs(mesh: Mesh, stiffness: Floats, damping: Floats) -> Springs:
    """Return the springs of a mesh with constants (m,)."""
    return Springs(
        pairs=mesh.springs, rest_lengths=mesh.rest_lengths, stiffness=stiffness, damping=damping, rings=mesh.rings
    )


def membrane_stiffness(mesh: Mesh, k: Floats) -> Floats:
    """Turn a material's k [N/m] into one constant per spring, (m,) [N/m].

    k_e = k (A_1 + A_2) / (l^2 sqrt(3) / 2): the sheet's stiffness depends on neither resolution nor
    triangulation, and k_e = k where the triangles are equilateral. Source: Van Gelder 1998.
    """
    length = np.maximum(mesh.rest_lengths, 1e-9 * mesh.size)
    return k * mesh.spring_areas / (length**2 * np.sqrt(3) / 2)


def around(rings: Rings, x: Floats, part: slice = slice(None)) -> Floats:
    """Gather the vectors (3, w, n) from each vertex, or from those of a part, to the neighbours round it."""
    neighbours = rings.neighbours[:, part]
    vectors = np.empty((3, *neighbours.shape))
    for c in range(3):
        np.take(x[c], neighbours, out=vectors[c], mode="clip")  # the fast way: no check of bounds, no buffer
        vectors[c] -= x[c, part]
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
    square = np.maximum(np.einsum("csn,csn->sn", d, d), TINY)
    tension = np.sqrt(square)
    rest, stiffness = law.in_slots
    np.divide(rest, tension, out=tension)
    np.subtract(1, tension, out=tension)
    tension *= stiffness
    if v is not None:
        growth = np.einsum("csn,csn->sn", d, around(law.rings, v))
        growth *= law.damping_in_slots
        growth /= square
        tension += growth
    f = np.einsum("sn,csn->cn", tension, d)
    _add_irregular(law, f, x, v)
    return f


def _add_irregular(law: Springs, f: Floats, x: Floats, v: Floats | None) -> None:
    irregular = law.rings.irregular_springs
    if not len(irregular):
        return
    i, j = law.pairs[irregular].T
    d = x[:, j] - x[:, i]
    square = np.maximum((d * d).sum(axis=0), TINY)
    tension = law.stiffness[irregular] * (1 - law.rest_lengths[irregular] / np.sqrt(square))
    if v is not None:
        tension += law.damping[irregular] * (d * (v[:, j] - v[:, i])).sum(axis=0) / square
    pull, (at_i, at_j) = tension * d, law.rings.irregular_ends.T
    for c in range(3):
        f[c] += sums_at(i[at_i], pull[c, at_i], x.shape[1]) - sums_at(j[at_j], pull[c, at_j], x.shape[1])
