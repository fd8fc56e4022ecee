"""What owns and steps a body: the native core, here or in the process of a device."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Protocol, cast

from .. import native
from ..base import DimpleError, Floats
from ..body.model import Model
from ..body.regions import Regions
from .motion import Frame, Motion
from .scene import Collider

WORKERS = min(os.cpu_count() or 1, 64)  # the library takes no more
BITS = {"native": 32, "native64": 64}  # of the state, by the name of a backend


class Body(Protocol):
    """What steps a body; `native.Body` says more."""

    model: Model

    def set_constants(self, model: Model, *, surface: Model | None = None) -> None: ...
    def set_rest(self, rest: Floats, rate: Floats | None = None) -> None: ...
    def wake(self) -> None: ...
    @property
    def rest_volume(self) -> float: ...
    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None: ...
    def positions(self) -> Floats: ...
    def velocities(self) -> Floats: ...
    def step(self, motion: Motion) -> Frame: ...


def create(
    model: Model, *, surface: Model | None = None, backend: str = "native", regions: Regions | None = None
) -> Body:
    """Return a body at rest that owns its state.

    Args:
        surface: the model below whose surface at rest fingertips are measured, where `model` is its proxy.
        backend: "native" (single precision) or "native64".
        regions: that rest and wake by themselves, None where all of it is stepped.

    Raises:
        DimpleError: no such backend, or no native core runs here.
    """
    if backend not in BITS:
        raise DimpleError(f"There is no backend {backend}: take native or native64.")
    return native.Body(model, native.library(), surface=surface, regions=regions, bits=BITS[backend])


def step_bodies(bodies: Sequence[Body], motions: Sequence[Motion]) -> list[Frame]:
    """Run a motion of each of several bodies that do not meet: in one call, on all cores, where they are here."""
    if len(bodies) > 1 and all(isinstance(body, native.Body) for body in bodies):
        return native.step_many(cast(Sequence[native.Body], bodies), motions, workers=WORKERS)
    return [body.step(motion) for body, motion in zip(bodies, motions, strict=True)]


def create_scene(
    bodies: Sequence[Body], colliders: Sequence[Collider], *, itself: Sequence[int], offsets: Sequence[float] = ()
) -> native.Scene:
    """Return bodies and colliders that are stepped together; see `native.Scene`."""
    soft = cast(Sequence[native.Body], bodies)
    return native.Scene(soft, colliders, native.library(), itself=itself, offsets=offsets)
