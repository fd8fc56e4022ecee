"""Vertex block descent: backward Euler, solved by sweeps that move each vertex to where its own forces balance.

The step minimises m |x - y|^2 / (2 h^2) + E(x), y = x_0 + h v_0 + h^2 g. A vertex takes a Newton step of three unknowns
with its neighbours fixed; vertices of one colour share no spring and move at once. The fill couples all vertices: its
pressure is fixed during a sweep, then corrected for the volume that the sweep left, as if only the blocks on the
diagonal resisted. The number of sweeps is fixed: what they leave unsolved acts as added inertia.
Source: Chen et al. 2024.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from core.base import Floats, Ints
from core.body import pressure
from core.body.model import Model
from core.body.shape_matching import Pose, ShapeMatching
from studies.reference.laws import State, pose_of, rigid_velocity, shape_velocity

from ..reference.contact import Touch
from . import penalty
from .cached import kept
from .colours import colours
from .implicit import run_implicit
from .newton import meet_faces
from .penalty import Meeting
from .tangent import stiffness_parts

SWEEPS = 4
CONTACT = 3.0  # stiffness of a contact over that of a vertex: if stiffer, sweeps leave forces that are far off
_TINY = 1e-30


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """The vertices of one colour and, slot by slot, their springs; an empty slot joins a vertex to itself.

    vertices: (b,) indices.
    mass: (b,) [kg].
    matching: their shape matching, without the tension.
    others: (w, b) vertex at the other end of each spring.
    rest: (w, b) length at rest [m].
    stiffness: (w, b) [N/m], 0 in an empty slot.
    damping: (w, b) [N s/m].
    arms: (3, w, b) to the other end in the shape at rest [m].
    tension: (w, b) between the displacements of both ends [N/m], 0 in an empty slot.
    """

    vertices: Ints
    mass: Floats
    matching: ShapeMatching
    others: Ints
    rest: Floats
    stiffness: Floats
    damping: Floats
    arms: Floats
    tension: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Fixed:
    """What a sweep keeps fixed.

    goal: (3, n) y, where inertia alone would take the vertices [m].
    before: (3, n) positions at the start of the step [m].
    drift: (3, n) the same, carried along with the pose or with the rigid motion of a free body [m].
    pose: of the shape at rest.
    fill: (3, n) force of the fill [N].
    met: contacts; of each its corners (3, c, 3) [m] and the stiffness it adds to each vertex (n, 3, 3) [N/m].
    """

    goal: Floats
    before: Floats
    drift: Floats
    pose: Pose
    fill: Floats
    met: Sequence[tuple[Meeting, Floats, Floats]]


def advance(model: Model, state: State, touches: Sequence[Touch], dt: float, *, sweeps: int = SWEEPS) -> Floats:
    """Advance a state in place by dt [s] and return the impulses (k, 3) [N s] on the fingertips."""
    x, v, w = state.positions, state.velocities, model.inverse_mass
    before = x.copy()
    goal = x + dt * v + dt * dt * np.where(w > 0, model.gravity[:, None], 0.0)
    x[:] = goal
    _, g = pressure.volume_and_gradient(model.pressure, x)
    for _ in range(sweeps):
        met = meet_faces(model, state, touches, CONTACT)
        carried = dt * shape_velocity(model.matching, state.pose_rate)
        drift = before + (carried if state.pose else rigid_velocity(model.matching.mass, x, x - before))
        fixed = Fixed(
            goal=goal, before=before, drift=drift, pose=pose_of(model.matching, x, state.pose),
            fill=state.pressure * g, met=[(m, x[:, m.corners], penalty.stiffness_blocks(m, x.shape[1])) for m in met],
        )  # fmt: skip
        inverse = np.zeros((6, len(w)))
        for block in kept(model, blocks):
            inverse[:, block.vertices] = move(block, x, fixed, dt)
        g = correct_pressure(model, state, inverse)
    met = meet_faces(model, state, touches, CONTACT)
    v[:] = (x - before) / dt
    if state.pose is None and not model.pinned.any():
        keep_momentum(model, state, goal, before, met, dt)
    return dt * np.array([m.reaction for m in met]).reshape(-1, 3)


run = partial(run_implicit, advance)


def blocks(model: Model) -> list[Block]:
    """Return the vertices that may move, colour by colour: no spring joins two of one colour."""
    law, n = model.springs, len(model.mass)
    springs = np.tile(np.arange(len(law.pairs)), 2)
    ends, others = law.pairs.T.ravel(), law.pairs[:, ::-1].T.ravel()
    order = np.argsort(ends, kind="stable")
    ends, others, springs = ends[order], others[order], springs[order]
    first, valence = np.searchsorted(ends, np.arange(n)), np.bincount(ends, minlength=n)
    found = []
    for colour in colours(ends, springs):
        who = colour[model.inverse_mass[colour] > 0]
        if not len(who):
            continue
        slots = np.arange(valence[who].max())[:, None]
        used = slots < valence[who]
        at = np.where(used, first[who] + slots, 0)
        shape, to = model.matching, np.where(used, others[at], who)
        constants = law.rest_lengths, law.stiffness, law.damping, shape.tension
        rest, stiffness, damping, tension = (np.where(used, c[springs[at]], 0.0) for c in constants)
        found.append(
            Block(
                vertices=who, mass=model.mass[who], others=to, rest=rest, stiffness=stiffness, damping=damping,
                arms=shape.rest[:, to] - shape.rest[:, None, who], tension=tension,
                matching=ShapeMatching(
                    rest=shape.rest[:, who], k1=shape.k1[who], k2=shape.k2[who], d0=shape.d0[who],
                    damping=shape.damping[who], mass=shape.mass[who],
                    pairs=np.zeros((0, 2), np.int64), tension=np.zeros(0), pull=shape.pull[:, who],
                ),
            )
        )  # fmt: skip
    return found


def move(block: Block, x: Floats, fixed: Fixed, h: float) -> Floats:
    """Move the vertices of one colour, in place; return the inverse of their blocks (6, b) [m/N]."""
    at = block.vertices
    here, inertia = x[:, at], block.mass / (h * h)
    d = x[:, block.others] - here[:, None]
    length = np.maximum(np.sqrt(np.einsum("cwb,cwb->wb", d, d)), _TINY)
    n = d / length
    growth = np.einsum("cwb,cwb->wb", n, d - fixed.before[:, block.others] + fixed.before[:, at][:, None])
    pull = block.stiffness * (length - block.rest) + block.damping / h * growth
    force = np.einsum("wb,cwb->cb", pull, n) - inertia * (here - fixed.goal[:, at]) + fixed.fill[:, at]
    # a spring under compression pushes sideways; left out, so that every block is positive
    across = block.stiffness * np.maximum(1 - block.rest / length, 0)
    along = block.stiffness + block.damping / h - across
    along[block.stiffness == 0] = 0

    level, turn, u = stiffness_parts(block.matching, here, fixed.pose)
    force -= level * u + block.matching.damping / h * (here - fixed.drift[:, at])
    force += (block.tension * (d - np.tensordot(fixed.pose[0], block.arms, 1))).sum(axis=1)
    flat = inertia + level + block.matching.damping / h + (across + block.tension).sum(axis=0)
    matrix = np.stack([np.einsum("wb,wb,wb->b", along, n[a], n[b]) + turn * u[a] * u[b] for a, b in PAIRS])
    matrix[:3] += flat
    for met, then, stiffest in fixed.met:
        if len(met.depths):
            now = met.depths - (met.normals * ((x[:, met.corners] - then) * met.weights).sum(axis=2)).sum(axis=0)
            here_met = replace(met, depths=np.maximum(now, 0))
            force += penalty.force(here_met, x.shape[1])[:, at]
            stiff = stiffest[at]
            matrix += np.stack([stiff[:, a, b] for a, b in PAIRS])
    inverse = inverted(matrix)
    x[:, at] = here + times(inverse, force)
    return inverse


def correct_pressure(model: Model, state: State, inverse: Floats) -> Floats:
    """Make pressure and volume consistent with each other, in place; return dV/dx (3, n) [m2]."""
    law = model.pressure
    volume, g = pressure.volume_and_gradient(law, state.positions)
    if law.kind:
        # (D + s g g^T) dx = (p - p_held) g, s = -dp/dV: Sherman and Morrison
        eased = times(inverse, g)
        more = pressure.pressure_at(law, volume) - state.pressure
        more /= 1 + pressure.pressure_slope(law, volume) * float((g * eased).sum())
        state.positions += more * eased
        state.pressure += more
    return g


def keep_momentum(model: Model, state: State, goal: Floats, before: Floats, met: Sequence[Meeting], dt: float) -> None:
    """Remove, in place, the rigid motion that unfinished sweeps leave: only gravity and fingertips change momentum."""
    pushed = (goal - before) / dt
    for m in met:
        pushed = pushed + dt * penalty.force(m, pushed.shape[1]) / model.mass
    stray = rigid_velocity(model.matching.mass, state.positions, state.velocities - pushed)
    state.velocities -= stray
    state.positions -= dt * stray


# symmetric matrices of three rows, (6, b): xx, yy, zz, xy, xz, yz
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def inverted(m: Floats) -> Floats:
    """Return the inverse of symmetric matrices (6, b)."""
    xx, yy, zz, xy, xz, yz = m
    minors = np.stack(
        [
            yy * zz - yz * yz,
            xx * zz - xz * xz,
            xx * yy - xy * xy,
            xz * yz - xy * zz,
            xy * yz - xz * yy,
            xy * xz - xx * yz,
        ]
    )
    return minors / (xx * minors[0] + xy * minors[3] + xz * minors[4])


def times(m: Floats, v: Floats) -> Floats:
    """Return the products (3, b) of symmetric matrices (6, b) and vectors (3, b)."""
    xx, yy, zz, xy, xz, yz = m
    return np.stack(
        [xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2], xz * v[0] + yz * v[1] + zz * v[2]]
    )
