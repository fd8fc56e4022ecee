"""Contact of fingertip spheres with faces as one more law with an energy: for implicit methods and equilibria.

    E = sum over faces of c / 2 max(R - d, 0)^2,   d the distance of the centre from the face

A face is met at its nearest point, so a vertex is met as the corner of its faces. The projection of
`core.body.contact` cannot stand in here: it comes after the solve, and a stiff body has then already given way by
M / (M + h^2 K) of the force. The price is a little penetration, force over stiffness, and no friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.base import Floats, Ints, sums_at

from ..reference.contact import Touch
from ..reference.facets import bulge, met_radius, nearest_on_triangles

_TINY = 1e-30


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """The faces inside a fingertip: corners (c, 3), weights of the nearest points (c, 3), normals outward from
    the centre (3, c), depths (c,) [m] and stiffness (c,) [N/m]."""

    corners: Ints
    weights: Floats
    normals: Floats
    depths: Floats
    stiffness: Floats

    @property
    def reaction(self) -> Floats:
        """Return the force (3,) [N] on the fingertip."""
        return -(self.stiffness * self.depths * self.normals).sum(axis=1)


def meeting(x: Floats, touch: Touch, stiffness: Floats, rest: Floats) -> Meeting:
    """Find the faces inside a fingertip at positions (3, n) [m].

    Args:
        stiffness: (n,) [N/m] that a vertex is met with.
        rest: (3, n) [m] where the bulge of a facet is taken, so that the sphere it meets does not change as it moves.
    """
    corners = x[:, touch.triangles]
    weights = nearest_on_triangles(corners, touch.centre)
    offset = (corners * weights).sum(axis=2) - touch.centre[:, None]
    distance = np.sqrt((offset**2).sum(axis=0))
    sunk = bulge(rest[:, touch.triangles], touch.radius)
    radius = met_radius(sunk, touch.radius, sunk)
    hit = distance < radius
    members = touch.triangles[hit]
    return Meeting(
        corners=members, weights=weights[hit], normals=offset[:, hit] / np.maximum(distance[hit], _TINY),
        depths=(radius - distance)[hit], stiffness=stiffness[members].mean(axis=1),
    )  # fmt: skip


def energy(met: Meeting) -> float:
    """Return the energy [J]."""
    return float((met.stiffness * met.depths**2).sum()) / 2


def force(met: Meeting, n: int) -> Floats:
    """Return the forces (3, n) [N] on the vertices."""
    return spread(met, met.stiffness * met.depths, n)


def stiffness_product(met: Meeting, s: Floats) -> Floats:
    """Return K s (3, n) [N] for a displacement s, the nearest points and normals held."""
    along = (met.normals * (s[:, met.corners] * met.weights).sum(axis=2)).sum(axis=0)
    return spread(met, met.stiffness * along, s.shape[1])


def stiffness_blocks(met: Meeting, n: int) -> Floats:
    """Return the blocks (n, 3, 3) [N/m] on the diagonal of K."""
    each = met.stiffness[:, None] * met.weights**2
    blocks = np.empty((n, 3, 3))
    for a in range(3):
        for b in range(3):
            part = each * (met.normals[a] * met.normals[b])[:, None]
            blocks[:, a, b] = sums_at(met.corners.ravel(), part.ravel(), n)
    return blocks


def spread(met: Meeting, amounts: Floats, n: int) -> Floats:
    """Return (3, n): amounts (c,) along the normals, shared out by the weights."""
    to = (amounts * met.normals)[:, :, None] * met.weights
    return np.stack([sums_at(met.corners.ravel(), to[c].ravel(), n) for c in range(3)])
