"""Which code owns and steps a body: the native core where there is one, else its numpy twin."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Protocol, cast

from .. import native
from ..base import DimpleError, Floats
from ..body.model import Model
from ..body.regions import Regions
from .motion import Frame, Motion
from .scene import Collider, Scene
from .twin import Twin
from .twin_scene import TwinScene

WORKERS = min(os.cpu_count() or 1, 64)  # the library takes no more


class Body(Protocol):
    """What either backend offers; `native.Body` says more."""

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


def choose_backend(wanted: str = "auto") -> tuple[str, str]:
    """Return the name of what steps, and why it is not the native core.

    Args:
        wanted: "auto", "native" (single precision), "native64" or "numpy".

    Raises:
        DimpleError: it does not exist, or cannot run here and was asked for by name.
    """
    if wanted not in ("auto", "native", "native64", "numpy"):
        raise DimpleError(f"There is no backend {wanted}: take auto, native, native64 or numpy.")
    note = "" if wanted == "numpy" else native.why_not()
    if note and wanted != "auto":
        raise DimpleError(note)
    return ("numpy" if note or wanted == "numpy" else wanted.replace("auto", "native")), note


def create(
    model: Model, *, surface: Model | None = None, backend: str = "auto", regions: Regions | None = None
) -> Body:
    """Return a body at rest that owns its state.

    Args:
        surface: the model below whose surface at rest fingertips are measured, where `model` is its proxy.
        backend: as in `choose_backend`.
        regions: that rest and wake by themselves, None where all of it is stepped.

    Raises:
        DimpleError: as in `choose_backend`.
    """
    name, _ = choose_backend(backend)
    if name == "numpy":
        return Twin(model, surface=surface, regions=regions)
    return native.Body(model, native.library(), surface=surface, regions=regions, bits=64 if name == "native64" else 32)


def step_bodies(bodies: Sequence[Body], motions: Sequence[Motion]) -> list[Frame]:
    """Run a motion of each of several bodies that do not meet: in one call, on all cores, where they are native."""
    if len(bodies) > 1 and all(isinstance(body, native.Body) for body in bodies):
        return native.step_many(cast(Sequence[native.Body], bodies), motions, workers=WORKERS)
    return [body.step(motion) for body, motion in zip(bodies, motions, strict=True)]


def create_scene(
    bodies: Sequence[Body],
    colliders: Sequence[Collider],
    *,
    itself: Sequence[int],
    backend: str,
    offsets: Sequence[float] = (),
) -> Scene:
    """Return bodies and colliders that are stepped together.

    Args:
        bodies: of one backend.
        itself: whether each body meets itself too; LEAVES_OUT: but for what passes through itself now.
        backend: that the bodies have.
        offsets: the distance [m] that each body holds, 0 for a share of its edges, as all do by default; colliders hold
            the least of them.
    """
    if backend == "numpy":
        return TwinScene(cast(Sequence[Twin], bodies), colliders, itself=itself, offsets=offsets)
    soft = cast(Sequence[native.Body], bodies)
    return native.Scene(soft, colliders, native.library(), itself=itself, offsets=offsets)
