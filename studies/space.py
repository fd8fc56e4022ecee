"""Convergence in space: the shape of a dent on finer and finer meshes of one body."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from core.base import Floats
from core.body.estimate import spread_on
from core.fields import at_rest
from core.reduction.cells import vertex_normals
from core.session import Finger, Session

from .scenes import FINGERTIP, poke_ball, poke_cube

SECONDS = 1.0  # that the press takes, and then that the body rests: it oscillates little
DEPTH = 0.020  # [m]
REACH, SAMPLES = 0.040, 41  # how far from the middle of the dent its depth is known [m]
WIDE = 2.5  # [tip radius + spread] half the width of a profile
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
        below = np.interp(places, *profile(session, 0))
        for beside, depth in zip(places.tolist(), below.tolist(), strict=True):
            yield Below(
                scene=scene, vertices=len(x), beside=beside, depth=depth,
                volume_ratio=frame.volume / frame.rest_volume,
            )  # fmt: skip


def profile(session: Session, finger: int) -> tuple[Floats, Floats]:
    """Return a cut through the dent of a fingertip: distances from its centre (p,) [m] and depths (p,) [m].

    The cut runs along the horizontal axis of the scene that is more perpendicular to the press.
    """
    tip, mesh = session.placed[finger], session.model.mesh
    touch = session.frame.touches[finger]
    if tip is None or touch is None:
        return np.zeros(0), np.zeros(0)
    inward, rest = -np.array(touch.outward), at_rest(session)
    along = np.eye(3)[int(np.abs(inward[:2]).argmin())]
    along = along - (along @ inward) * inward
    along /= np.linalg.norm(along)
    arms = rest - touch.centre
    beside, distance = arms @ np.cross(inward, along), arms @ along
    width = WIDE * (tip.radius + max(spread_on(material, mesh.size) for material in session.model.materials))
    normals = vertex_normals(mesh.triangles, rest)
    near = (normals @ inward < 0) & (np.abs(distance) < 1.5 * width)
    i, j = mesh.springs[near[mesh.springs].all(axis=1)].T
    cut = (beside[i] > 0) != (beside[j] > 0)
    i, j = i[cut], j[cut]
    share = beside[i] / (beside[i] - beside[j])
    below = ((rest - session.skin()) * normals).sum(axis=1)
    at, deep = (a[i] + share * (a[j] - a[i]) for a in (distance, below))
    order = np.argsort(at)
    order = order[np.abs(at[order]) <= width]
    return at[order], deep[order]


def difference(found: Sequence[Below], vertices: int, finest: int) -> float:
    """Return the root mean square difference of a dent from that on the finest mesh, over the depth of the press."""
    coarse, fine = (np.array([at.depth for at in found if at.vertices == n]) for n in (vertices, finest))
    return float(np.sqrt(((coarse - fine) ** 2).mean()) / DEPTH)
