"""Convergence in space: the shape of a dent on finer and finer meshes of one body."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from core import fields
from core.session import Finger, Session

from .scenes import FINGERTIP, poke_ball, poke_cube

SECONDS = 1.0  # that the press takes, and then that the body rests: it oscillates little
DEPTH = 0.020  # [m]
REACH, SAMPLES = 0.040, 41  # how far from the middle of the dent its depth is known [m]
SCENES: dict[str, Callable[[int], Session]] = {"poke_ball": poke_ball, "poke_cube": poke_cube}


@dataclass(frozen=True, slots=True, kw_only=True)
class Below:
    """How deep a dent is at one place.

    scene: name in SCENES.
    vertices: of the mesh.
    beside: the middle of the dent [m].
    depth: of the surface below that at rest there [m].
    volume_ratio: volume of the body over that at rest.
    """

    scene: str
    vertices: int
    beside: float
    depth: float
    volume_ratio: float


def dents(scene: str, sizes: Sequence[int]) -> Iterator[Below]:
    """Press a scene slowly on meshes of several sizes."""
    for size in sizes:
        session = SCENES[scene](size)
        x = session.model.mesh.rest_positions
        top = x[:, 2].max() + FINGERTIP
        for depth in (0.0, DEPTH, DEPTH):
            session.set_fingers([Finger((0.0, 0.0, top - depth), FINGERTIP)])
            frame = session.step(SECONDS)
        places = np.linspace(-REACH, REACH, SAMPLES)
        below = np.interp(places, *fields.profile(session, 0))
        for beside, depth in zip(places.tolist(), below.tolist(), strict=True):
            yield Below(
                scene=scene, vertices=len(x), beside=beside, depth=depth,
                volume_ratio=frame.volume / frame.rest_volume,
            )  # fmt: skip


def difference(found: Sequence[Below], vertices: int, finest: int) -> float:
    """Return the root mean square difference of a dent from that on the finest mesh, over the depth of the press."""
    coarse, fine = (np.array([at.depth for at in found if at.vertices == n]) for n in (vertices, finest))
    return float(np.sqrt(((coarse - fine) ** 2).mean()) / DEPTH)
