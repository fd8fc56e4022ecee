"""Props: rigid meshes that fall, collide with soft bodies, colliders, each other and the ground, and come to rest.

A prop is a collider that moves by its own dynamics. To soft bodies it is a collider with its current velocity; their
reaction in a substep acts on it in the next one. That is stable as long as the prop is heavier than the skin that moves
with it, so a lighter prop is given a larger inertia but keeps its own weight.

Surfaces in contact keep a distance, so the contact surface of a prop is its visible surface moved inwards by that
distance: then the visible prop stands on what it touches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats
from ..body import rigid
from ..body.rigid import RigidShape, RigidState
from ..constants import CREASE, OFFSET
from ..native.scene import Collider, Fall, Falling
from ..session import Session

LEAST_SHARE = 0.1  # [mass of the lightest body] smallest mass with which a prop moves


@dataclass(slots=True, kw_only=True)
class Prop:
    """A collider that falls.

    falling: rigid body of its contact surface.
    share: ratio of its own mass to the mass with which it moves; gravity is multiplied by it.
    state: its position and velocity.
    lowest: height of its lowest vertex at the start [m]; for this prop the ground is never higher.
    """

    falling: Falling
    share: float
    state: RigidState
    lowest: float

    def positions(self) -> Floats:
        """Return the positions of the contact surface's vertices (3, m) [m]."""
        return np.ascontiguousarray(rigid.positions(self.falling.shape, self.state).T)

    def pose(self) -> Floats:
        """Return its rigid motion since the start as a matrix (4, 4) with the translation in [m]."""
        state, motion = self.state, np.eye(4)
        motion[:3, :3] = state.turn
        motion[:3, 3] = state.centre - state.turn @ self.falling.shape.centre
        return motion

    def way(self, gravity: Floats, ground: float | None) -> Fall:
        """Return its state with the gravity and the ground that act on it."""
        return Fall(self.state, self.share * gravity, -math.inf if ground is None else min(ground, self.lowest))


def prop_of(seen: Collider, mass: float, sessions: Sequence[Session]) -> Prop:
    """Return a collider as a prop with a mass [kg] that falls among the bodies of sessions.

    Raises:
        DimpleError: it has no mass or no faces.
    """
    shape = rigid.rigid_shape(seen.positions.T, seen.triangles, mass)
    gap = min(map(touching_gap, sessions))
    touching, by = shrunk(seen, gap)
    moves = _heavier(replace(shape, arms=touching.positions.T - shape.centre), sessions)
    falling = Falling(moves, shape.arms, _damping(moves.mass, sessions), by or gap)
    return Prop(
        falling=falling, share=mass / moves.mass, state=rigid.at_rest(moves), lowest=float(seen.positions[2].min())
    )


def touching_gap(session: Session) -> float:
    """Return the distance that a body keeps from a collider that it touches [m]."""
    return 2 * OFFSET * float(session.model.mesh.rest_lengths.mean())


def shrunk(collider: Collider, by: float) -> tuple[Collider, float]:
    """Return a collider with its faces moved inwards, and the distance [m]: smaller if it is thin, 0 if it is open."""
    x, triangles = collider.positions.T, collider.triangles
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    if not {(a, b) for a, b in sides.tolist()} == {(b, a) for a, b in sides.tolist()}:
        return collider, 0.0  # it has no inside
    corners = (x - x.mean(axis=0))[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas, volume = np.linalg.norm(normals, axis=1), float(np.linalg.det(corners).sum()) / 6
    normals /= np.copysign(np.maximum(areas, 1e-30), volume)[:, None]
    by = min(by, abs(volume) / max(float(areas.sum()), 1e-30))  # a plate keeps half of its thickness
    # displacement d of each vertex, the least-squares solution for its faces: normal . d = -by. Two normals with the
    # cosine of a crease between them span eigenvalues of this ratio; what turns less counts as flat
    squares, sums = np.zeros((len(x), 3, 3)), np.zeros((len(x), 3))
    for k in range(3):
        np.add.at(squares, triangles[:, k], normals[:, :, None] * normals[:, None, :])
        np.add.at(sums, triangles[:, k], normals)
    flat = (1 - CREASE) / (1 + CREASE)
    way = -by * np.einsum("mij,mj->mi", np.linalg.pinv(squares, rcond=flat, hermitian=True), sums)
    return collider._replace(positions=np.ascontiguousarray((x + way).T)), by


def _heavier(shape: RigidShape, sessions: Sequence[Session]) -> RigidShape:
    """Return a rigid body with enough mass to be stable although reactions act one substep late."""
    least = LEAST_SHARE * min(float(session.model.mass.sum()) for session in sessions)
    if shape.mass >= least:
        return shape
    return replace(shape, mass=least, inertia=least / shape.mass * shape.inertia)


def _damping(mass: float, sessions: Sequence[Session]) -> float:
    """Return the damping [N s/m] of a prop in contact: as for bodies, a fraction of the critical damping."""
    materials = [material for session in sessions for material in session.model.materials]
    return min(m.damping_ratio * 2 * math.sqrt(min(m.K1, m.K2) * mass) for m in materials)
