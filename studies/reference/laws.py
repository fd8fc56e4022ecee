"""The laws of a body as the reference steps them: damped, with the shape at rest as it moves, ring by ring.

Their parameters, energies and static forces are those of `core.body`.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass, field, replace

import numpy as np

from core.base import Floats, sums_at
from core.body import pressure
from core.body.model import Model
from core.body.shape_matching import Pose, ShapeMatching, displacements, fit_pose, secant, tension_force
from core.body.springs import Springs
from core.constants import TINY
from core.mesh.rings import Rings


@dataclass(slots=True, kw_only=True)
class State:
    """The moving part of a body.

    positions: (3, n) [m].
    velocities: (3, n) [m/s].
    pose: of the shape at rest where pins hold it, None where the body is free.
    pose_rate: how fast that pose changes [1/s], [m/s], None where the pins rest.
    rest_rate: (3, n) how fast the places at rest move [m/s], None where they do not.
    volume: [m3] at the last evaluation of the forces.
    pressure: [Pa] at the last evaluation.
    unsolved: implicit steps so far that found no solution.
    kept: (3, vertices and faces) what each fingertip did in the last step: `contact.Touch`.
    """

    positions: Floats
    velocities: Floats
    pose: Pose | None
    pose_rate: Pose | None = None
    rest_rate: Floats | None = None
    volume: float = 0.0
    pressure: float = 0.0
    unsolved: int = 0
    kept: dict[int, Floats] = field(default_factory=dict)


def initial_state(model: Model) -> State:
    """Return the state at rest."""
    x = np.array(model.mesh.rest_positions.T, order="C")  # a copy, whatever the order of the mesh's
    pose = None if model.free else (np.eye(3), np.zeros(3))
    return State(positions=x, velocities=np.zeros_like(x), pose=pose)


def pose_of(law: ShapeMatching, x: Floats, pose: Pose | None) -> Pose:
    """Return the pose of the shape at rest: the given one, or the best fit to x."""
    return fit_pose(law.rest, x, law.k1, law.pull) if pose is None else pose


def forces(model: Model, state: State) -> Floats:
    """Return the force (3, n) [N] on every vertex: the right-hand side of every method. Source: Eq. (5)."""
    x, v = state.positions, state.velocities
    f = spring_force(model.springs, x, v)
    state.volume = state.pressure = 0.0
    if model.pressure.kind:
        state.volume, gradient = pressure.volume_and_gradient(model.pressure, x)
        state.pressure = pressure.pressure_at(model.pressure, state.volume)
        f += state.pressure * gradient
    f += matching_force(model.matching, x, v, state.pose, state.pose_rate, state.rest_rate)
    return f + model.mass * model.gravity[:, None]


_slots: dict[int, tuple[Floats, Floats, Floats]] = {}


def in_slots(law: Springs) -> tuple[Floats, Floats, Floats]:
    """Return rest lengths, stiffness and damping slot by slot (w, n), 0 in padded slots; kept with the springs."""
    if id(law) not in _slots:
        at = law.rings.springs
        lengths, stiffness, damping = (
            np.where(at < 0, 0.0, values.take(at, mode="clip"))
            for values in (law.rest_lengths, law.stiffness, law.damping)
        )
        _slots[id(law)] = lengths, stiffness, damping
        weakref.finalize(law, _slots.pop, id(law), None)
    return _slots[id(law)]


def around(rings: Rings, x: Floats) -> Floats:
    """Gather the vectors (3, w, n) from each vertex to the neighbours round it."""
    vectors = np.empty((3, *rings.neighbours.shape))
    for c in range(3):
        np.take(x[c], rings.neighbours, out=vectors[c], mode="clip")  # the fast way: no check of bounds, no buffer
        vectors[c] -= x[c]
    return vectors


def spring_force(law: Springs, x: Floats, v: Floats | None = None) -> Floats:
    """Return the forces (3, n) [N] of springs and, given velocities (3, n) [m/s], of the dashpots beside them."""
    d = around(law.rings, x)
    square = np.maximum(np.einsum("csn,csn->sn", d, d), TINY)
    rest, stiffness, damping = in_slots(law)
    tension = stiffness * (1 - rest / np.sqrt(square))
    if v is not None:
        tension += damping * np.einsum("csn,csn->sn", d, around(law.rings, v)) / square
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


def matching_force(
    law: ShapeMatching,
    x: Floats,
    v: Floats | None = None,
    pose: Pose | None = None,
    pose_rate: Pose | None = None,
    rest_rate: Floats | None = None,
) -> Floats:
    """Return the forces (3, n) [N] of shape matching; of a free body, without a pose, they have no net force or torque.

    Args:
        pose_rate, rest_rate: how fast the given pose and the places at rest move, against which damping acts.
    """
    now = pose_of(law, x, pose)
    u = displacements(law, x, now)
    f = tension_force(law.pairs, law.tension, u) - secant(law, u) * u
    if v is not None:
        moving = shape_velocity(law, pose_rate) if pose is not None else rigid_velocity(law.mass, x, v)
        if rest_rate is not None:
            moving = moving + now[0] @ rest_rate
        f -= law.damping * (v - moving)
    if pose is None:
        f -= law.mass * rigid_velocity(law.mass, x, f / law.mass)
    return f


def shape_velocity(law: ShapeMatching, pose_rate: Pose | None) -> Floats | float:
    """Return the velocities (3, n) [m/s] of the places in the shape at rest, 0 where pins do not move it."""
    return 0.0 if pose_rate is None else pose_rate[0] @ law.rest + pose_rate[1][:, None]


def rigid_velocity(mass: Floats, x: Floats, v: Floats) -> Floats:
    """Return the rigid part (3, n) of a velocity field: the one with the same linear and angular momentum."""
    total = mass.sum()
    r = x - (x @ mass / total)[:, None]
    mean = v @ mass / total
    momentum = np.cross(r, v - mean[:, None], axis=0) @ mass
    inertia = np.eye(3) * (mass * r * r).sum() - (mass * r) @ r.T
    # a straight line of vertices has no inertia about itself
    spin = np.linalg.pinv(inertia, hermitian=True) @ momentum
    return mean[:, None] + np.cross(spin[:, None], r, axis=0)


def carried_pose(rest: Floats, here: Floats, there: Floats, *, tick: float, substeps: int) -> tuple[Pose, Pose]:
    """Return the pose of a shape whose pins go from here to there (3, p) in a tick [s], and how fast it changes.

    Over the tick it stands where the substeps begin on average: so the body neither leads nor lags.
    """
    weight = np.ones(rest.shape[1])
    (turned, moved), (turns, moves) = fit_pose(rest, here, weight), fit_pose(rest, there, weight)
    turn, move, share = turns - turned, moves - moved, (1 - 1 / substeps) / 2
    return (turned + share * turn, moved + share * move), (turn / tick, move / tick)


def on_its_way(model: Model, rate: Floats, seconds: float) -> Model:
    """Return a model whose places at rest are where they were some seconds before those of its mesh.

    Args:
        rate: (3, n) with which they move there [m/s].
    """
    rest, law = model.mesh.rest_positions.T - seconds * rate, model.matching
    return replace(model, matching=replace(law, rest=rest, pull=tension_force(law.pairs, law.tension, rest)))
