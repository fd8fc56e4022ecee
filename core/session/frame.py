"""What a session shows after a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import Floats
from ..mesh.surface import Mesh
from ..native.motion import Touch
from ..vectors import ZERO, dot


class Frame(NamedTuple):
    """What a session shows after a step; its arrays are made when they are read.

    time: [s].
    touches: one for each fingertip, None for a lifted one.
    mesh: the mesh shown.
    pressure: [Pa].
    volume: [m3].
    rest_volume: [m3].
    substeps: number in a tick.
    steps: number of ticks in this step.
    cost: wall time of this step [s].
    total_steps: number of substeps since the start.
    work: done by the fingertips on the body since the start [J].
    note: "" or a sentence.
    """

    time: float
    touches: tuple[Touch | None, ...]
    mesh: Mesh
    pressure: float
    volume: float
    rest_volume: float
    substeps: int
    steps: int
    cost: float
    total_steps: int
    work: float
    note: str

    @property
    def finger_forces(self) -> Floats:
        """Return the forces (k, 3) on the fingertips [N]: the measured law at their depths, and friction."""
        return np.array([touch.force if touch else ZERO for touch in self.touches]).reshape(-1, 3)

    @property
    def pushes(self) -> Floats:
        """Return the outward force on each fingertip (k,) [N]: what a force gauge reads there."""
        return np.array([dot(touch.force, touch.outward) if touch else 0.0 for touch in self.touches])

    @property
    def depths(self) -> Floats:
        """Return the depth x of Eq. (1) of each fingertip (k,) [m]."""
        return np.array([max(touch.depth, 0.0) if touch else 0.0 for touch in self.touches])

    @property
    def materials(self) -> tuple[int, ...]:
        """Return the index of the material under each fingertip (k,), -1 for a lifted one."""
        return tuple([int(self.mesh.triangle_material[touch.triangle]) if touch else -1 for touch in self.touches])

    @property
    def finite(self) -> bool:
        """Return whether the state is finite: the simulation has not blown up."""
        return not self.note
