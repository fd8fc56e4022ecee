"""Props: rigid meshes with a mass that fall, meet soft bodies, colliders, each other and the ground, and come to rest.

A prop is a collider that goes where it falls. To soft bodies it is one that goes at its speed; what they answer in a
substep acts in the next one. That is stable while a prop is heavier than the skin that moves with it, so a lighter one
moves as if it were that heavy, though it presses with its own weight.

Surfaces that touch keep a distance, so what touches of a prop is its surface moved inwards by that: then the prop as it
is seen stands on what it meets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base import Floats
from ..body import rigid
from ..body.rigid import RigidShape
from ..constants import OFFSET
from ..native import motion
from ..native.scene import Collider, Fall, Falling, Way
from ..session import Session
from .world import World

LEAST_SHARE = 0.1  # of the lightest body's mass: what a prop has at least when it moves
SETTLING = 0.05  # of the critical damping is the least that a prop has, so that it comes to rest
THIN = 0.5  # of volume by area: the farthest that faces are moved inwards
FLAT = 0.02  # below this share of the greatest, nothing is known of where the faces of a vertex look


class PropWorld(World):
    """Step sessions with colliders some of which fall.

    gravity: (3,) that pulls props [m/s2]; may be changed between steps, as may
    ground: height [m] of a plane that props land on, or None; one that begins below it lies as low as it begins.

    Args:
        sessions, colliders, itself, names: as for a World.
        masses: of the colliders [kg], None for one that is led.

    Raises:
        DimpleError: a prop without mass or faces, or something passes through something else.
    """

    def __init__(
        self,
        sessions: Sequence[Session],
        colliders: Sequence[Collider],
        *,
        masses: Sequence[float | None],
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        ground: float | None = None,
        itself: Sequence[bool] | None = None,
        names: Sequence[str] = (),
    ) -> None:
        gap = min(map(touching_gap, sessions))
        self.gravity, self.ground = np.array(gravity, np.float64), ground
        self.masses = {i: float(mass) for i, mass in enumerate(masses) if mass is not None}
        falling = {i: _falling(colliders[i], mass, gap, sessions) for i, mass in self.masses.items()}
        self.shapes = {i: each.shape for i, each in falling.items()}
        self.states = {i: rigid.at_rest(shape) for i, shape in self.shapes.items()}
        self._lowest = {i: float(colliders[i].positions[2].min()) for i in self.masses}
        touching = [
            c._replace(positions=np.ascontiguousarray(self.positions(i).T), falling=falling[i]) if i in falling else c
            for i, c in enumerate(colliders)
        ]
        super().__init__(sessions, touching, itself=itself, names=names)

    def positions(self, index: int) -> Floats:
        """Return where the vertices (m, 3) [m] are of what touches of a prop."""
        return rigid.positions(self.shapes[index], self.states[index])

    def pose(self, index: int) -> Floats:
        """Return the rigid motion (4, 4) of a prop since the start; translations in [m]."""
        state, motion = self.states[index], np.eye(4)
        motion[:3, :3] = state.turn
        motion[:3, 3] = state.centre - state.turn @ self.shapes[index].centre
        return motion

    def _way(self, index: int) -> Way:
        if index not in self.states:
            return super()._way(index)
        pull = self.masses[index] / self.shapes[index].mass * self.gravity  # its own weight, whatever it moves as
        ground = -math.inf if self.ground is None else min(self.ground, self._lowest[index])
        return Fall(self.states[index], pull, ground)

    def _run(self, sessions: Sequence[Session], at_once: int) -> tuple[Sequence[motion.Frame], int]:
        found = super()._run(sessions, at_once)
        for i in self.states:
            self._at[i] = np.ascontiguousarray(self.positions(i).T)
        return found


def touching_gap(session: Session) -> float:
    """Return the distance that a body keeps from a collider that it touches [m]."""
    return 2 * OFFSET * float(session.model.mesh.rest_lengths.mean())


def shrunk(collider: Collider, by: float) -> tuple[Collider, float]:
    """Return a collider with its faces moved inwards by a distance [m], and that: less if it is thin, 0 if open."""
    x, triangles = collider.positions.T, collider.triangles
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    if not {(a, b) for a, b in sides.tolist()} == {(b, a) for a, b in sides.tolist()}:
        return collider, 0.0  # it has no inside
    corners = (x - x.mean(axis=0))[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas, volume = np.linalg.norm(normals, axis=1), float(np.linalg.det(corners).sum()) / 6
    normals /= np.copysign(np.maximum(areas, 1e-30), volume)[:, None]
    by = min(by, THIN * abs(volume) / max(float(areas.sum()) / 2, 1e-30))
    # of each vertex the way d that is the best for its faces: normal . d = -by
    squares, sums = np.zeros((len(x), 3, 3)), np.zeros((len(x), 3))
    for k in range(3):
        np.add.at(squares, triangles[:, k], areas[:, None, None] * normals[:, :, None] * normals[:, None, :])
        np.add.at(sums, triangles[:, k], areas[:, None] * normals)
    way = -by * np.einsum("mij,mj->mi", np.linalg.pinv(squares, rcond=FLAT, hermitian=True), sums)
    return collider._replace(positions=np.ascontiguousarray((x + way).T)), by


def _falling(seen: Collider, mass: float, gap: float, sessions: Sequence[Session]) -> Falling:
    shape = rigid.rigid_shape(seen.positions.T, seen.triangles, mass)
    touching, by = shrunk(seen, gap)
    moves = _heavier(replace(shape, arms=touching.positions.T - shape.centre), sessions)
    return Falling(moves, shape.arms, _damping(moves.mass, sessions), by or gap)


def _heavier(shape: RigidShape, sessions: Sequence[Session]) -> RigidShape:
    """Return a rigid body that is heavy enough to be answered a substep later."""
    least = LEAST_SHARE * min(float(session.model.mass.sum()) for session in sessions)
    if shape.mass >= least:
        return shape
    return replace(shape, mass=least, inertia=least / shape.mass * shape.inertia)


def _damping(mass: float, sessions: Sequence[Session]) -> float:
    """Return the damping [N s/m] of a prop: as that of the bodies is, a share of the critical one."""
    materials = [material for session in sessions for material in session.model.materials]
    return min(max(m.damping_ratio, SETTLING) * 2 * math.sqrt(min(m.K1, m.K2) * mass) for m in materials)
