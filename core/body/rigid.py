"""A rigid body that falls and turns: six degrees of freedom, moved by forces and moments.

    m dv/dt = F + m g,   dL/dt = M,   omega = R I^-1 R^T L

The state holds the angular momentum, so that without moments it is conserved to rounding. Each step rotates about
omega, so that the shape is preserved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import DimpleError, Floats, Ints
from ..constants import ROUNDING
from ..mesh.surface import Mesh, capped
from .time_step import STABLE


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidShape:
    """Mass and geometry of a rigid body.

    mass: [kg].
    inertia: (3, 3) about its centre of mass, at the start [kg m2].
    centre: (3,) of mass, at the start [m].
    arms: (m, 3) from there to its vertices [m].
    """

    mass: float
    inertia: Floats
    centre: Floats
    arms: Floats


@dataclass(slots=True, kw_only=True)
class RigidState:
    """Position and motion of a rigid body.

    centre: (3,) [m].
    turn: (3, 3) rotation from the start.
    velocity: (3,) of the centre [m/s].
    momentum: (3,) angular, about the centre [kg m2/s].
    """

    centre: Floats
    turn: Floats
    velocity: Floats
    momentum: Floats


def rigid_shape(positions: Floats, triangles: Ints, mass: float) -> RigidShape:
    """Return the rigid body of a mesh (m, 3) [m], with uniform density, or uniform thickness if it encloses no volume.

    Raises:
        DimpleError: the mass is not positive, or the mesh has no area.
    """
    if not 0 < mass < math.inf:
        raise DimpleError("The mass of a prop must be greater than 0 kg (it is {mass:g}).", mass=mass)
    x = np.asarray(positions, np.float64)
    middle = x[np.unique(triangles)].mean(axis=0)
    corners = (x - middle)[triangles]  # (t, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas, volumes = np.linalg.norm(normals, axis=1) / 2, (corners[:, 0] * normals).sum(axis=1) / 6
    size = float(np.ptp(x, axis=0).max())
    if not areas.sum() > (ROUNDING * size) ** 2:
        raise DimpleError("The prop has no faces with an area, so it cannot touch anything.")
    shell = abs(volumes.sum()) < ROUNDING * size * areas.sum()
    # second moments over a tetrahedron with a corner at the origin, and over a triangle
    weight, first, second = (areas, 3.0, 12.0) if shell else (volumes, 4.0, 20.0)
    weight = weight / weight.sum()
    total = corners.sum(axis=1)
    centre = weight @ total / first
    moments = sum((weight * at.T) @ at for at in (*corners.swapaxes(0, 1), total))
    moments = moments / second - np.outer(centre, centre)
    return RigidShape(
        mass=mass, inertia=_inertia(mass * moments, mass * size**2), centre=middle + centre, arms=x - middle - centre
    )  # fmt: skip


def _inertia(moments: Floats, whole: float) -> Floats:
    """Return the inertia (3, 3) by the second moments of the mass, and a bound on it [kg m2]."""
    least = ROUNDING * whole  # a straight line of vertices has no inertia about itself
    inertia: Floats = (np.trace(moments) + least) * np.eye(3) - moments
    return inertia


def fill_momentum(mesh: Mesh, mass: Floats) -> Floats:
    """Return the angular momentum of a solid's fill over that of its skin (3, 3), in the shape at rest.

    The skin has all the mass (n,) [kg], and so more inertia than the solid: the fill turns against it.
    """
    x, total = mesh.rest_positions, float(mass.sum())
    solid = rigid_shape(*capped(mesh), total).inertia
    arms = x - mass @ x / total
    skin = _inertia((mass * arms.T) @ arms, total * mesh.size**2)
    momentum: Floats = solid @ np.linalg.inv(skin) - np.eye(3)
    # explicit steps are stable up to 1; of the meshes in the studies a tetrahedron has the most, 0.81
    return momentum / max(1.0, float(np.linalg.norm(momentum, 2)) / STABLE)


def at_rest(shape: RigidShape) -> RigidState:
    """Return the state at the start, at rest."""
    return RigidState(centre=shape.centre.copy(), turn=np.eye(3), velocity=np.zeros(3), momentum=np.zeros(3))


def positions(shape: RigidShape, state: RigidState) -> Floats:
    """Return the positions of the vertices (m, 3) [m]."""
    at: Floats = shape.arms @ state.turn.T + state.centre
    return at
