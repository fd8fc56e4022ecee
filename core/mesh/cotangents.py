"""The cotangent weights of a surface at rest: what turns differences along edges into a gradient on the surface."""

from __future__ import annotations

import numpy as np

from ..base import Floats, mean_of_pairs, row_parts, sums_at, sums_of_three
from .surface import Mesh

LEAST = 0.25  # of its weights a vertex keeps, where nearly all triangles round it are blunt
LARGEST = 4.0  # of an edge between the long sides of slivers: more would shorten the time step and hold no better


def cotangent_weights(mesh: Mesh) -> Floats:
    """Return w (m,) of every spring of a mesh: half the sum of the cotangents of the angles opposite the edge.

    The sum over edges of w |u_i - u_j|^2 is the integral of |grad u|^2. Where angles are so blunt that w would be
    negative it is 0, so that no energy is; the weights round such an edge are less by as much, or a surface of blunt
    triangles would be stiffer than its area.
    """
    n, ends, square = len(mesh.rest_positions), mesh.springs, mesh.rest_lengths**2
    cotangents = np.empty((len(mesh.triangles), 3))
    for part in row_parts(len(cotangents)):  # the law of cosines: 4 A cot = b^2 + c^2 - a^2
        sides = square[mesh.triangle_springs[part]]
        area = np.maximum(2 * mesh.triangle_areas[part], 1e-12 * mesh.size**2)
        cotangents[part] = (sums_of_three(sides)[:, None] / 2 - sides) / area[:, None]
    total = sums_at(mesh.triangle_springs.ravel(), cotangents.ravel(), len(ends)) / 2
    weights = np.clip(total, 0, LARGEST)
    wanted, kept = (sums_at(ends.ravel(), np.repeat(w * square, 2), n) for w in (total, weights))
    return weights * mean_of_pairs(np.clip(wanted / np.maximum(kept, 1e-30), LEAST, 1.0), ends)
