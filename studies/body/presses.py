"""Presses that show how near a proxy is to its mesh: the fingertip goes down in 0.15 s and stays there for 0.1 s."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from core.base import TICK, DimpleError, Floats, Singles
from core.body.model import Model
from core.mesh.surface import Mesh
from core.native import create
from core.native.motion import Motion
from core.reduction.cells import vertex_normals
from studies.motions import straight

DOWN, HOLD = 0.15, 0.1  # [s]
DEPTH = 0.5  # of the fingertip's radius
DENT = 0.1  # of the largest displacement: vertices that move more belong to the dent
BESIDE_PINS = 2.0  # fingertip radii: nearer to a pinned vertex, a press meets the pins rather than the body
DRAWN = 10  # candidates for each place that is taken: those beside pinned vertices are rejected


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """A press straight into the surface.

    at: (3,) the point of the surface where the fingertip touches [m].
    outward: (3,) unit normal of the surface there.
    radius: of the fingertip [m].
    depth: how far the fingertip goes in [m].
    """

    at: Floats
    outward: Floats
    radius: float
    depth: float


def choose_presses(model: Model, radius: float, count: int, *, seed: int = 0) -> list[Press]:
    """Choose places for presses at random: evenly over the free surface, away from pinned vertices.

    Args:
        radius: of the fingertip [m].
        count: of presses; fewer come back where not so many vertices are free.

    Raises:
        DimpleError: every vertex is pinned.
    """
    mesh, rng = model.mesh, np.random.default_rng(seed)
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    share = np.where(~model.pinned & (np.abs(normals).sum(axis=1) > 0), mesh.vertex_areas, 0.0)
    if not share.sum() > 0:
        raise DimpleError("No part of the surface is free to be pressed. Pin fewer vertices.")
    pinned = mesh.rest_positions[model.pinned & ~mesh.loose]
    most = min(DRAWN * count, int(np.count_nonzero(share)))
    drawn = rng.choice(len(share), most, replace=False, p=share / share.sum())
    away = [v for v in drawn if _distance(pinned, mesh.rest_positions[v]) > BESIDE_PINS * radius]
    depth = min(DEPTH * radius, mesh.size / 8)
    places = (away or drawn.tolist())[:count]
    return [Press(at=mesh.rest_positions[v], outward=normals[v], radius=radius, depth=depth) for v in places]


def _distance(points: Floats, place: Floats) -> float:
    return float(np.sqrt(((points - place) ** 2).sum(axis=1).min())) if len(points) else math.inf


def pressed(model: Model, press: Press, *, chunk: int = 10) -> Floats:
    """Press a body from rest; return where its vertices (3, n) are at the end [m], NaN where it blew up."""
    body, ticks = create(model), round((DOWN + HOLD) / TICK)
    down = np.minimum(np.arange(0, ticks + 1, chunk) * TICK / DOWN, 1) * press.depth
    centres = [(press.at + press.outward * (press.radius - depth)).tolist() for depth in down]
    for part, (start, end) in enumerate(zip(centres, centres[1:], strict=False)):
        tip = straight(start, end, ticks=chunk, radius=press.radius, fresh=part == 0)
        if not body.step(Motion(chunk, model.substeps(TICK), TICK, (tip,))).finite:
            return np.full_like(body.positions(), np.nan)
    return body.positions()


def dent_error(mesh: Mesh, skin: Floats | Singles, wanted: Floats) -> float:
    """Return the root-mean-square distance [m] between two surfaces (n, 3) [m], along the normal, over the dent.

    Sliding along the surface cannot be seen, so only the normal part counts. The dent is where vertices move by DENT
    of the largest displacement or more: all others would lower the mean.
    """
    moved = np.sqrt(((wanted - mesh.rest_positions) ** 2).sum(axis=1))
    dent = moved > DENT * moved.max()
    along = ((skin - wanted) * vertex_normals(mesh.triangles, wanted)).sum(axis=1)[dent]
    return float(np.sqrt((along**2).mean()))
