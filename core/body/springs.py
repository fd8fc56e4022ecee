"""Springs along the edges, with dashpots beside them.

    E = sum k (|l| - l0)^2 / 2,   f_i = sum_j k (1 - l0 / |l|) l_ij,   l_ij = x_j - x_i

and a dashpot along each edge, given as a fraction of the critical damping of its two vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints, sums_at
from ..constants import TINY
from ..mesh.rings import Rings
from ..mesh.surface import Mesh


@dataclass(frozen=True, kw_only=True)
class Springs:
    """The springs of a mesh.

    pairs: (m, 2) the vertices that they connect.
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


def build_springs(mesh: Mesh, stiffness: Floats, damping: Floats) -> Springs:
    """Return the springs of a mesh with constants (m,)."""
    return Springs(
        pairs=mesh.springs, rest_lengths=mesh.rest_lengths, stiffness=stiffness, damping=damping, rings=mesh.rings
    )


def membrane_stiffness(mesh: Mesh, k: Floats) -> Floats:
    """Return the constant of each spring (m,) [N/m] for a material's k (m,) [N/m].

    k_e = k (A_1 + A_2) / (l^2 sqrt(3) / 2) makes the stiffness of the sheet independent of resolution and
    triangulation, and k_e = k for equilateral triangles. Source: Van Gelder 1998.
    """
    length = np.maximum(mesh.rest_lengths, 1e-9 * mesh.size)
    return k * mesh.spring_areas / (length**2 * np.sqrt(3) / 2)


def force(law: Springs, x: Floats) -> Floats:
    """Return the forces (3, n) [N] of the springs, without their dashpots, at positions (3, n) [m]."""
    i, j = law.pairs.T
    d = x[:, j] - x[:, i]
    pull = law.stiffness * (1 - law.rest_lengths / np.maximum(np.sqrt((d * d).sum(axis=0)), TINY)) * d
    return np.stack([sums_at(i, p, x.shape[1]) - sums_at(j, p, x.shape[1]) for p in pull])
