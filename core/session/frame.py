"""What a session shows after a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import Floats
from ..mesh.surface import Mesh
from ..native.motion import Touch
from ..vectors import ZERO, Vector, dot


class Frame(NamedTuple):
    """What a session shows after a step; its arrays are made when they are read.

    time: [s].
    impulses: on the fingertips [N s], and
    seconds: the time they took, of the last step that had a tick [s].
    touches: one for each fingertip, None where it is lifted.
    mesh: that is shown.
    pressure: [Pa].
    volume: [m3].
    rest_volume: [m3].
    substeps: in a tick.
    steps: ticks done.
    cost: wall time [s].
    total_steps: substeps since the start.
    work: of the fingertips on the body since the start [J].
    note: "" or a sentence.
    """

    time: float
    impulses: tuple[Vector, ...]
    seconds: float
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
        """Return the forces (k, 3) on the fingertips [N]: of the measured law at their depths, and of friction."""
        return np.array([touch.force if touch else ZERO for touch in self.touches]).reshape(-1, 3)

    @property
    def pushes(self) -> Floats:
        """Return how hard each fingertip is pushed out of the surface (k,) [N]: what a gauge reads there."""
        return np.array([dot(touch.force, touch.outward) if touch else 0.0 for touch in self.touches])

    @property
    def depths(self) -> Floats:
        """Return the x of Eq. (1) of each fingertip (k,) [m]."""
        return np.array([max(touch.depth, 0.0) if touch else 0.0 for touch in self.touches])

    @property
    def materials(self) -> tuple[int, ...]:
        """Return which of the model's materials each fingertip (k,) is nearest to, -1 where none is down."""
        return tuple([int(self.mesh.triangle_material[touch.triangle]) if touch else -1 for touch in self.touches])

    @property
    def finite(self) -> bool:
        """Tell whether the body is whole: it has not blown up."""
        return not self.note
