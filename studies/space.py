"""Convergence in space: the force on a fingertip, F(x), on finer and finer meshes of one body."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from core.session import Finger, Session

from .scenes import FINGERTIP, poke_ball, poke_cube

SECONDS = 1.0  # of the press: so slow that the body oscillates little
DEPTH = 0.020  # [m]
SAMPLES = 40
SCENES: dict[str, Callable[[int], Session]] = {"poke_ball": poke_ball, "poke_cube": poke_cube}


@dataclass(frozen=True, slots=True, kw_only=True)
class Force:
    """The force on a fingertip at one depth.

    scene: name in SCENES.
    vertices: of the mesh.
    depth: of the fingertip [m].
    force: on the fingertip [N].
    volume_ratio: volume over that at rest.
    """

    scene: str
    vertices: int
    depth: float
    force: float
    volume_ratio: float


def forces(scene: str, sizes: Sequence[int]) -> Iterator[Force]:
    """Press a scene slowly on meshes of several sizes."""
    for size in sizes:
        session = SCENES[scene](size)
        x = session.model.mesh.rest_positions
        top = x[:, 2].max() + FINGERTIP
        session.set_fingers([Finger((0.0, 0.0, top), FINGERTIP)])
        for i in range(1, SAMPLES + 1):
            depth = DEPTH * i / SAMPLES
            session.set_fingers([Finger((0.0, 0.0, top - depth), FINGERTIP)])
            frame = session.step(SECONDS / SAMPLES)
            yield Force(
                scene=scene, vertices=len(x), depth=depth, force=float(frame.finger_forces[0, 2]),
                volume_ratio=frame.volume / frame.rest_volume,
            )  # fmt: skip


def difference(found: Sequence[Force], vertices: int, finest: int) -> float:
    """Return the root mean square difference of F(x) from that on the finest mesh, over its largest force."""
    coarse, fine = ([f.force for f in found if f.vertices == n] for n in (vertices, finest))
    square = sum((a - b) ** 2 for a, b in zip(coarse, fine, strict=True)) / len(fine)
    return float(square**0.5 / max(fine))
