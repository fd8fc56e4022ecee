"""The forces on the vertices of a body."""

from __future__ import annotations

from typing import NamedTuple

from ..base import Floats
from . import pressure, shape_matching, springs
from .model import Model, State
from .shape_matching import Pose


def forces(model: Model, state: State) -> Floats:
    """Return the force (3, n) [N] on every vertex: the right-hand side of every method. Source: Eq. (5)."""
    x, v = state.positions, state.velocities
    f, state.volume, state.pressure = law_forces(model, x, state.pose, v, state.pose_rate)
    return f + model.mass * model.gravity[:, None]


class Shape(NamedTuple):
    """What a mesh at some positions is to the laws, whatever their constants.

    arms: (3, w, n) [m] from each vertex to those round it.
    volume: [m3] and its gradient (3, n) [m2], None where there is no fill.
    """

    arms: Floats
    volume: tuple[float, Floats] | None


def shape_of(model: Model, x: Floats) -> Shape:
    """Return the shape of a body at positions (3, n) [m]."""
    arms = springs.around(model.mesh.rings, x)
    filled = model.pressure.kind
    return Shape(arms, pressure.volume_and_gradient(model.pressure, x, arms) if filled else None)


def law_forces(
    model: Model,
    x: Floats,
    pose: Pose | None,
    v: Floats | None = None,
    pose_rate: Pose | None = None,
    shape: Shape | None = None,
) -> tuple[Floats, float, float]:
    """Return the forces (3, n) [N] of the laws, undamped without velocities, and volume and pressure.

    The last two are 0 where there is no fill.

    Args:
        shape: at x, of this model or of one with other constants, where the caller has it already.
    """
    arms, enclosed = shape or shape_of(model, x)
    f, volume, inner = springs.force(model.springs, x, v, arms), 0.0, 0.0
    if model.pressure.kind:
        volume, gradient = enclosed or pressure.volume_and_gradient(model.pressure, x, arms)
        inner = pressure.pressure_at(model.pressure, volume)
        f += inner * gradient
    f += shape_matching.force(model.matching, x, v, pose, pose_rate)
    return f, volume, inner
