"""A shape at rest that changes while the body lives, as a rig bends it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base import Floats
from . import pressure, shape_matching, springs
from .model import Model


def with_rest(model: Model, rest: Floats) -> Model:
    """Return a model with another shape at rest, and the lengths and the volume that follow from it.

    Masses, stiffness and what else its materials came to stay: the same matter, bent.

    Args:
        rest: (3, n) [m].
    """
    i, j = model.mesh.springs.T
    volume = pressure.volume(model.pressure, rest)
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
        matching=replace(model.matching, rest=np.array(rest), pull=pull, rate=None),
    )  # fmt: skip


def on_its_way(model: Model, rate: Floats, seconds: float) -> Model:
    """Return a model whose places at rest are as many seconds before where they are led, and move there.

    Args:
        model: with the shape at rest that they are led to.
        rate: (3, n) [m/s].
    """
    rest = model.mesh.rest_positions.T - seconds * rate
    law = model.matching
    pull = shape_matching.tension_force(law.pairs, law.tension, rest)
    return replace(model, matching=replace(law, rest=rest, pull=pull, rate=rate))
