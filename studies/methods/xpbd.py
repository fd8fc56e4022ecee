"""Extended position based dynamics with small substeps: each law in turn moves the vertices it joins.

A law with energy k C^2 / 2 and dashpot c that moves vertices of inverse mass w along its gradient n does so by

    l = -h (h k C + c n . (x - x_before)) / (1 + h (h k + c) sum w),   x += w l n

which is backward Euler for that law alone: it takes into account the laws before it in the substep, not those after it.
Against another law, one of stiffness k so acts with k / (1 + h^2 k w): right as the substeps get small, too soft where
h^2 k w is large. The multiplier of the volume is the pressure itself, so air needs no other form.
Source: Macklin et al. 2016 (compliance, damping); Macklin et al. 2019 (substeps instead of iterations).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.base import Floats, Ints
from core.body import pressure
from core.body.model import Model
from studies.reference.laws import State, pose_of, rigid_velocity, shape_velocity

from ..reference.path import FingerPath
from ..reference.ticks import run_ticks
from .cached import kept
from .colours import colours
from .tangent import stiffness_parts

_TINY = 1e-30


@dataclass(frozen=True, slots=True, kw_only=True)
class Edges:
    """The springs of one colour.

    i, j: (e,) vertices at their ends.
    rest: (e,) lengths at rest [m].
    stiffness: (e,) [N/m].
    damping: (e,) [N s/m].
    arms: (3, e) from i to j in the shape at rest [m].
    tension: (e,) between the displacements of their ends [N/m].
    w_i, w_j: (e,) inverse mass of their ends [1/kg].
    """

    i: Ints
    j: Ints
    rest: Floats
    stiffness: Floats
    damping: Floats
    arms: Floats
    tension: Floats
    w_i: Floats
    w_j: Floats


def advance(model: Model, state: State, dt: float, _acceleration: Floats | None = None) -> None:
    """Advance a state in place by dt [s]."""
    x, v, w = state.positions, state.velocities, model.inverse_mass
    before = x.copy()
    v += dt * np.where(w > 0, model.gravity[:, None], 0.0)
    x += dt * v
    for edges in kept(model, spring_colours):
        move_springs(edges, x, before, dt)
    move_to_shape(model, state, before, dt)
    move_by_pressure(model, state, dt)
    v[:] = (x - before) / dt


def run(model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats:
    """Advance a state in place by the ticks [s] of a path and return the impulses (k, 3) [N s] on the fingertips.

    Raises:
        DimpleError: the laws have no energy.
    """
    return run_ticks(advance, model, state, path, tick=tick, substeps=substeps)


def spring_colours(model: Model) -> list[Edges]:
    """Return the springs colour by colour: no vertex is in two springs of one colour."""
    law, shape, w = model.springs, model.matching, model.inverse_mass
    ends, arms = law.pairs.ravel(), shape.rest[:, law.pairs[:, 1]] - shape.rest[:, law.pairs[:, 0]]
    return [
        Edges(
            i=law.pairs[at, 0], j=law.pairs[at, 1], rest=law.rest_lengths[at], stiffness=law.stiffness[at],
            damping=law.damping[at], arms=arms[:, at], tension=shape.tension[at],
            w_i=w[law.pairs[at, 0]], w_j=w[law.pairs[at, 1]],
        )
        for at in colours(np.repeat(np.arange(len(law.pairs)), 2), ends)
    ]  # fmt: skip


def move_springs(edges: Edges, x: Floats, before: Floats, h: float) -> None:
    """Move the ends of the springs of one colour, in place."""
    i, j = edges.i, edges.j
    x_i, x_j = x[:, i], x[:, j]
    d = x_j - x_i
    length = np.maximum(np.sqrt(np.einsum("ce,ce->e", d, d)), _TINY)
    n = d / length
    growth = np.einsum("ce,ce->e", n, d - before[:, j] + before[:, i])
    stiff = h * edges.stiffness
    push = -h * (stiff * (length - edges.rest) + edges.damping * growth)
    push /= 1 + h * (stiff + edges.damping) * (edges.w_i + edges.w_j)
    x[:, i] = x_i - edges.w_i * push * n
    x[:, j] = x_j + edges.w_j * push * n


def move_to_shape(model: Model, state: State, before: Floats, h: float) -> None:
    """Move the vertices toward the shape at rest, in place; a free body as a whole stays where it is."""
    law, x, w = model.matching, state.positions, model.inverse_mass
    start, pose = x.copy(), pose_of(law, x, state.pose)
    for edges in kept(model, spring_colours):
        move_by_tension(edges, x, pose[0], h)
    stiffness, _, u = stiffness_parts(law, x, pose)
    moved = x - before
    if state.pose is None:
        moved -= rigid_velocity(law.mass, x, moved)
    else:
        moved -= h * shape_velocity(law, state.pose_rate)
    stiff = h * stiffness
    shift = x - start - h * w * (stiff * u + law.damping * moved) / (1 + h * w * (stiff + law.damping))
    if state.pose is None:
        shift -= rigid_velocity(law.mass, x, shift)
    x[:] = start + np.where(w > 0, shift, 0.0)


def move_by_tension(edges: Edges, x: Floats, rotation: Floats, h: float) -> None:
    """Move the ends of the edges of one colour by the tension between their displacements, in place.

    C = u_j - u_i is a vector, and so is its multiplier.
    """
    apart = x[:, edges.j] - x[:, edges.i] - rotation @ edges.arms
    stiff = h * h * edges.tension
    push = stiff * apart / (1 + stiff * (edges.w_i + edges.w_j))
    x[:, edges.i] += edges.w_i * push
    x[:, edges.j] -= edges.w_j * push


def move_by_pressure(model: Model, state: State, h: float) -> None:
    """Move the vertices by the pressure of the fill, in place: p at the end of the substep, to first order."""
    law = model.pressure
    if not law.kind:
        return
    volume, g = pressure.volume_and_gradient(law, state.positions)
    per_pressure = h * h * model.inverse_mass * g
    give = pressure.pressure_slope(law, volume) * float((g * per_pressure).sum())
    state.pressure = pressure.pressure_at(law, volume) / (1 + give)
    state.positions += state.pressure * per_pressure
