"""Props: rigid meshes with a mass that fall on soft bodies, sink in by their weight, and rest or roll off.

A prop is a collider that goes where it falls. Each tick it is led on by its own velocity, and then given its weight and
what the bodies answered: the reaction of one tick acts in the next. That is stable while a prop is heavier than the
skin that moves with it, so a lighter one moves as if it were that heavy, though it presses with its own weight.

Surfaces that touch keep a distance, so what touches of a prop is its surface moved inwards by that: then the prop as it
is seen stands on the skin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .base import Floats
from .body.proximity import OFFSET
from .session import Session
from .solver import rigid
from .solver.rigid import RigidShape
from .solver.scene import Collider, SceneFrame
from .world import World

LEAST_SHARE = 0.1  # of the lightest body's mass: what a prop has at least when it moves
SETTLING = 0.05  # of the critical damping is the least that a prop has, so that it comes to rest
THIN = 0.5  # of volume by area: the farthest that faces are moved inwards
FLAT = 0.02  # below this share of the greatest, nothing is known of where the faces of a vertex look
HELD = 1e-9  # [m] a prop that is farther behind its way than this was held back


class PropWorld(World):
    """Step sessions with colliders some of which fall.

    Args:
        sessions, colliders, itself, apart, names: as for a World.
        masses: of the colliders [kg], None for one that is led.
        gravity: (3,) [m/s2].
        ground: height [m] of a plane that props land on, or None; one that begins below it lies as low as it begins.

    Raises:
        DimpleError: a prop without mass or faces, or something passes through something else.
    """

    most = 1  # tick in one call: each moves the props

    def __init__(
        self,
        sessions: Sequence[Session],
        colliders: Sequence[Collider],
        *,
        masses: Sequence[float | None],
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        ground: float | None = None,
        itself: Sequence[bool] | None = None,
        apart: Sequence[bool] | None = None,
        names: Sequence[str] = (),
    ) -> None:
        gap = min(map(touching_gap, sessions))
        touching = [c if mass is None else shrunk(c, gap) for c, mass in zip(colliders, masses, strict=True)]
        super().__init__(sessions, touching, itself=itself, apart=apart, names=names)
        self.gravity = np.array(gravity, np.float64)
        self.props = [i for i, mass in enumerate(masses) if mass is not None]
        self.masses = {i: float(masses[i] or 0.0) for i in self.props}
        self.shapes = {i: _heavier(_shape(colliders[i], touching[i], self.masses[i]), sessions) for i in self.props}
        self.states = {i: rigid.at_rest(shape) for i, shape in self.shapes.items()}
        self._friction = {i: colliders[i].friction for i in self.props}
        lowest = {i: float(colliders[i].positions[2].min()) for i in self.props}
        # as they are seen, for the ground needs no gap
        self._seen = {i: replace(s, arms=colliders[i].positions.T - s.centre) for i, s in self.shapes.items()}
        self._grounds = {i: min(ground, low) for i, low in lowest.items() if ground is not None}
        self._damping = {i: _damping(shape.mass, sessions) for i, shape in self.shapes.items()}

    def positions(self, index: int) -> Floats:
        """Return where the vertices (m, 3) [m] are of what touches of a prop."""
        return rigid.positions(self.shapes[index], self.states[index])

    def pose(self, index: int) -> Floats:
        """Return the rigid motion (4, 4) of a prop since the start; translations in [m]."""
        state, motion = self.states[index], np.eye(4)
        motion[:3, :3] = state.turn
        motion[:3, 3] = state.centre - state.turn @ self.shapes[index].centre
        return motion

    def reset(self) -> None:
        """Put everything back to where it was at the start."""
        self.states = {i: rigid.at_rest(shape) for i, shape in self.shapes.items()}
        super().reset()

    def _run(self, ticks: int, substeps: int, done: int, whole: int) -> SceneFrame:
        """Run a tick: each prop goes on, and is given what the bodies answer."""
        tick, share = self.sessions[0].tick, (done + ticks) / whole
        for i in self.props:
            rigid.move(self.shapes[i], self.states[i], tick)
            here = self._scene.collider(i)
            # all ways are of the whole step, of which so much is over at the end of this tick
            self._at[i], self._ends[i] = here, here + (self.positions(i).T - here) / share
        frame = super()._run(ticks, substeps, done, whole)
        for i in self.props:
            self._at[i], self._ends[i] = self._scene.collider(i), None
            self._wait(i, tick)
            self._push(i, frame, tick)
            if i in self._grounds:
                rigid.land(self._seen[i], self.states[i], self._grounds[i], self._friction[i])
        return frame

    def _push(self, index: int, frame: SceneFrame, tick: float) -> None:
        """Give a prop its weight and what it got in a tick [s]."""
        shape, state, row = self.shapes[index], self.states[index], len(self.sessions) + index
        impulse, moment = frame.impulses[row], frame.moments[row]
        weight = self.masses[index] * self.gravity  # its own, whatever it moves as
        rigid.push(state, shape.mass, impulse + tick * weight, moment - np.cross(state.centre, impulse))
        if impulse.any():
            share = 1 / (1 + tick * self._damping[index] / shape.mass)
            state.velocity, state.momentum = share * state.velocity, share * state.momentum

    def _wait(self, index: int, tick: float) -> None:
        """Let a prop that was held back be where it is, at the speed it got there."""
        behind = self._at[index].T - self.positions(index)
        if np.abs(behind).max() > HELD:
            state, way = self.states[index], behind.mean(axis=0)
            state.centre, state.velocity = state.centre + way, state.velocity + way / tick


def touching_gap(session: Session) -> float:
    """Return the distance that a body keeps from a collider that it touches [m]."""
    return 2 * OFFSET * float(session.model.mesh.rest_lengths.mean())


def shrunk(collider: Collider, by: float) -> Collider:
    """Return a closed collider with its faces moved inwards by a distance [m], or by less where it is thin."""
    x, triangles = collider.positions.T, collider.triangles
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    if not {(a, b) for a, b in sides.tolist()} == {(b, a) for a, b in sides.tolist()}:
        return collider  # it has no inside
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
    return collider._replace(positions=np.ascontiguousarray((x + way).T))


def _shape(seen: Collider, touching: Collider, mass: float) -> RigidShape:
    shape = rigid.rigid_shape(seen.positions.T, seen.triangles, mass)
    return replace(shape, arms=touching.positions.T - shape.centre)


def _heavier(shape: RigidShape, sessions: Sequence[Session]) -> RigidShape:
    """Return a rigid body that is heavy enough to be moved tick by tick."""
    least = LEAST_SHARE * min(float(session.model.mass.sum()) for session in sessions)
    if shape.mass >= least:
        return shape
    return replace(shape, mass=least, inertia=least / shape.mass * shape.inertia)


def _damping(mass: float, sessions: Sequence[Session]) -> float:
    """Return the damping [N s/m] of a prop: as that of the bodies is, a share of the critical one."""
    materials = [material for session in sessions for material in session.model.materials]
    return min(max(m.damping_ratio, SETTLING) * 2 * math.sqrt(min(m.K1, m.K2) * mass) for m in materials)
