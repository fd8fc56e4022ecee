"""The test of a library before its first use: a small body must fall and swing correctly."""

from __future__ import annotations

import ctypes

import numpy as np

from ..base import TICK
from ..body.model import Model, build_model
from ..constants import ROUNDING
from ..material import Material
from ..mesh.surface import mesh_from_triangles
from ..message import Message
from .body import Body, NativeError
from .motion import Motion


def check(library: ctypes.CDLL) -> None:
    """Let go of a stretched octahedron: it must swing, while its centre of mass falls freely.

    Raises:
        NativeError: it does not.
    """
    ticks, gravity = 4, 9.81
    model = octahedron(gravity)
    steps, before = ticks * model.substeps(TICK), 1.1 * model.matching.rest
    body = Body(model, library)
    body.set_state(before)
    body.step(Motion(ticks=ticks, substeps=model.substeps(TICK), tick=TICK))
    after, size = body.positions(), model.mesh.size
    fallen = gravity * (ticks * TICK) ** 2 / 2 * (1 + 1 / steps)  # by semi-implicit Euler
    centre = (after - before) @ model.mass / model.mass.sum()
    off = float(np.abs(centre + (0.0, 0.0, fallen)).max())
    swung = float(np.abs(np.ptp(after, axis=1) - np.ptp(before, axis=1)).min())
    if not (off < ROUNDING * size < swung < size):
        raise NativeError(Message("its check is off by {off:.3g} mm", off=1000 * off))


def octahedron(gravity: float) -> Model:
    """Return a soft octahedron in the air."""
    corners = np.concatenate([np.eye(3), -np.eye(3)]) * 0.05
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    material = Material(K1=600, K2=7000, x0=0.01, k=600, mass=0.1)
    return build_model(mesh_from_triangles(corners, faces), [material], gravity=(0.0, 0.0, -gravity))
