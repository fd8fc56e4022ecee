"""What an exporter gets: an object and its animation, as a point cache or as shape keys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    Singles = npt.NDArray[np.float32]


class KeyedShape(NamedTuple):
    """A shape key: its name, coordinates (vertices, 3), and its value at some frames."""

    name: str
    shape: Singles
    frames: Sequence[int]
    values: Sequence[float]


class Keys(NamedTuple):
    """The shape keys of a clip, and how far a vertex is off where they are played, at the most."""

    shapes: list[KeyedShape]
    error: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Clip:
    """An object and what it does.

    obj: the object.
    plays: the PC2 file of offsets that it is to play, its first frame, and how often its final mesh is subdivided; None
        where it plays already.
    samples: (frames, vertices, 3) coordinates of its final mesh, in frames first to last; none where no format asks.
    first, last: frames.
    step: frames from one shape key to the next.
    key_error: how far a vertex may be off where shape keys are few, as a share of the object's size; 0 for a shape key
        every `step` frames.
    normals: write how the surface is shaded.
    made: the shape keys, once they are.
    """

    obj: bpy.types.Object
    plays: tuple[Path, float, int] | None
    samples: Singles
    first: int
    last: int
    step: int = 1
    key_error: float = 0.0
    normals: bool = True
    made: list[Keys] = field(default_factory=list)

    def keys(self) -> Keys:
        """Return the shape keys; they are made once."""
        if not self.made:
            self.made.append(self._few() if self.key_error else self._each())
        return self.made[0]

    def _each(self) -> Keys:
        """Return a shape key for every few frames; from one to the next a straight line leads."""
        from ..core.recording.basis import error_between

        frames = sorted({*range(self.first, self.last + 1, self.step), self.last})
        at = [frame - self.first for frame in frames]
        near = [frames[max(number - 1, 0) : number + 2] for number in range(len(frames))]
        shapes = [
            KeyedShape(f"Frame {frame:04d}", self.samples[where], some, [float(each == frame) for each in some])
            for frame, where, some in zip(frames, at, near, strict=True)
        ]
        return Keys(shapes, error_between(self.samples, at))

    def _few(self) -> Keys:
        """Return the few shapes of which every frame is a sum."""
        from ..core.recording.basis import reduce

        basis = reduce(self.samples, self.key_error * float(np.ptp(self.samples[0], axis=0).max()))
        frames = list(range(self.first, self.last + 1))
        shapes = [
            KeyedShape(f"Shape {number:03d}", self.samples[0] + shape, frames, weights)
            for number, (shape, weights) in enumerate(zip(basis.shapes, basis.weights.T, strict=True), start=1)
        ]
        return Keys(shapes, basis.error)
