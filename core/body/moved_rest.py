"""A shape at rest that changes during a simulation, as when a rig bends it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base import Floats
from . import pressure, shape_matching, springs
from .model import Model


def with_rest(model: Model, rest: Floats) -> Model:
    """Return a model with another shape at rest, with the rest lengths and the volume that follow from it.

    Masses and stiffnesses stay, because the matter is the same.

    Args:
        rest: (3, n) [m].
    """
    i, j = model.mesh.springs.T
    volume = pressure.volume_and_gradient(model.pressure, rest)[0]
    mesh = replace(
        model.mesh, rest_positions=np.ascontiguousarray(rest.T),
        rest_lengths=np.sqrt(((rest[:, j] - rest[:, i]) ** 2).sum(axis=0)),
        volume=volume if volume > 0 else model.mesh.volume,  # a rig may turn a body inside out
    )  # fmt: skip
    pull = shape_matching.tension_force(mesh.springs, model.matching.tension, rest)
    return replace(
        model, mesh=mesh,
        springs=springs.build_springs(mesh, model.springs.stiffness, model.springs.damping),
        pressure=replace(model.pressure, rest_volume=mesh.volume),
        matching=replace(model.matching, rest=np.array(rest), pull=pull),
    )  # fmt: skip
