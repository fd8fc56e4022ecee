"""The energy that a running body holds."""

from __future__ import annotations

from .base import Floats
from .body import pressure, shape_matching, springs
from .body.model import Model
from .body.shape_matching import Pose
from .fields import pose_now
from .session import Session


def energies(session: Session) -> tuple[float, float]:
    """Return the energy [J] of a body's shape (springs, fill, shape matching) and that of its motion."""
    model, x, v = session.bent_model(), session.body.positions(), session.body.velocities()
    return stored(model, x, None if model.free else pose_now(model, x)), float((v * v).sum(axis=0) @ model.mass) / 2


def stored(model: Model, x: Floats, pose: Pose | None) -> float:
    """Return the energy [J] of a model's shape.

    Args:
        x: (3, n) positions [m].
        pose: of the shape at rest where pins hold it, None where it is free.
    """
    held = springs.energy(model.springs, x) + pressure.energy(model.pressure, x)
    return held + shape_matching.energy(model.matching, x, pose)
