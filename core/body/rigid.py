"""A rigid body that falls and turns: six degrees of freedom, moved by forces and moments.

    m dv/dt = F + m g,   dL/dt = M,   omega = R I^-1 R^T L

The angular momentum is what is stepped, so where nothing acts it is kept to rounding; each turn is a rotation about
omega by its length, so the shape is kept too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import DimpleError, Floats, Ints
from ..constants import ROUNDING


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidShape:
    """What a rigid body is.

    mass: [kg].
    inertia: (3, 3) about its centre, as it lies at the start [kg m2].
    centre: (3,) of its mass at the start [m].
    arms: (m, 3) of its vertices from there [m].
    """

    mass: float
    inertia: Floats
    centre: Floats
    arms: Floats


@dataclass(slots=True, kw_only=True)
class RigidState:
    """Where a rigid body is and how it moves.

    centre: (3,) [m].
    turn: (3, 3) rotation since the start.
    velocity: (3,) of the centre [m/s].
    momentum: (3,) angular, about the centre [kg m2/s].
    """

    centre: Floats
    turn: Floats
    velocity: Floats
    momentum: Floats


def rigid_shape(positions: Floats, triangles: Ints, mass: float) -> RigidShape:
    """Return the rigid body of a mesh (m, 3) [m] of even density, or of even thickness where it encloses nothing.

    Raises:
        DimpleError: no mass, or a mesh without an area.
    """
    if not 0 < mass < math.inf:
        raise DimpleError("The mass of a prop must be greater than 0 kg (it is {mass:g}).", mass=mass)
    x = np.asarray(positions, np.float64)
    middle = x[np.unique(triangles)].mean(axis=0)
    corners = (x - middle)[triangles]  # (t, 3, 3)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    volumes = np.linalg.det(corners) / 6
    size = float(np.ptp(x, axis=0).max())
    if not areas.sum() > (1e-6 * size) ** 2:
        raise DimpleError("The prop has no faces with an area, so it cannot touch anything.")
    shell = abs(volumes.sum()) < ROUNDING * size * areas.sum()
    # second moments over a tetrahedron with a corner at the origin, and over a triangle
    weight, first, second = (areas, 3.0, 12.0) if shell else (volumes, 4.0, 20.0)
    weight = weight / weight.sum()
    total = corners.sum(axis=1)
    centre = weight @ total / first
    moments = np.einsum("t,tki,tkj->ij", weight, corners, corners) + np.einsum("t,ti,tj->ij", weight, total, total)
    moments = moments / second - np.outer(centre, centre)
    inertia = mass * (np.trace(moments) * np.eye(3) - moments)
    least = 1e-6 * mass * size**2  # a straight line of vertices has no inertia about itself
    return RigidShape(
        mass=mass, inertia=inertia + least * np.eye(3), centre=middle + centre, arms=x - middle - centre
    )  # fmt: skip


def at_rest(shape: RigidShape) -> RigidState:
    """Return a rigid body where it was made, at rest."""
    return RigidState(centre=shape.centre.copy(), turn=np.eye(3), velocity=np.zeros(3), momentum=np.zeros(3))


def positions(shape: RigidShape, state: RigidState) -> Floats:
    """Return where its vertices (m, 3) [m] are."""
    at: Floats = shape.arms @ state.turn.T + state.centre
    return at


def spin(shape: RigidShape, state: RigidState) -> Floats:
    """Return its angular velocity (3,) [rad/s]."""
    rate: Floats = state.turn @ np.linalg.solve(shape.inertia, state.turn.T @ state.momentum)
    return rate


def rotation(turn: Floats) -> Floats:
    """Return the rotation (3, 3) about a vector (3,) by its length [rad]. Source: Rodrigues' formula."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-8:
        return np.eye(3) + cross + cross @ cross / 2
    return np.eye(3) + math.sin(angle) / angle * cross + (1 - math.cos(angle)) / angle**2 * cross @ cross


def energy(shape: RigidShape, state: RigidState, gravity: Floats) -> float:
    """Return its energy of motion and of height [J]."""
    moving = shape.mass * float(state.velocity @ state.velocity) + float(state.momentum @ spin(shape, state))
    return moving / 2 - shape.mass * float(gravity @ state.centre)
