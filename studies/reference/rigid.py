"""How a rigid body turns, and its energy."""

from __future__ import annotations

import math

import numpy as np

from core.base import Floats
from core.body.rigid import RigidShape, RigidState


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
