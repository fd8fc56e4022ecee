"""Where fingertips and colliders will press a body, and how much coarser than there its proxy may be elsewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints
from ..mesh.surface import Mesh

Vector = tuple[float, float, float]

FINE = 2.0  # fingertip radii round a place that is pressed within which a proxy is as fine as anywhere
GROWTH = 2 / 3  # of the finest spacing by which the spacing grows a radius further
FAR = 8.0  # finest spacings: how coarse it is at most
STEP = 0.5  # radii between two places of a path
REACH = 4.0  # radii between the centre of a fingertip and a place of the surface that it may press
LONGEST = 1e6  # steps of a path
MOST = 400  # places of paths; more are all over a body, and take long to look at
CELL = 2.0  # radii: two places where a collider comes near are so far from each other, and it is no farther from them
FACES = 200_000  # of a collider, in parts as small as that
LOOKED = 60_000  # vertices of a finer mesh that are looked at for a plan


class Pressed(NamedTuple):
    """What fingertips and colliders will press, and how.

    places: (k) of the surface at rest [m].
    radius: of the fingertips [m].
    depth: of the deepest press, or less [m].
    speed: of the fastest near the body [m/s].
    """

    places: tuple[Vector, ...]
    radius: float
    depth: float = 0.0
    speed: float = math.inf

    @property
    def where(self) -> Pressed:
        """Return the places alone, whatever depth and speed are."""
        return Pressed(self.places, self.radius)


class Led(NamedTuple):
    """A collider: its vertices (m, 3) [m] now, its triangles (t, 3), and its way (k, 3) [m] from there."""

    points: Floats
    triangles: Ints
    way: Floats


def pressed_by(
    mesh: Mesh, paths: list[Floats], radius: float, look: float = 0.0, colliders: Sequence[Led] = ()
) -> Pressed | None:
    """Return where fingertips whose centres go along paths (k, 3) [m], and colliders, come near a surface.

    None where they do so nowhere, or all over it, or go farther than can be looked at.

    Args:
        look: time [s] between two places of a path, 0 where it is not known.
    """
    looked = _looked(mesh)
    points, found = mesh.rest_positions[looked], set()
    low, high = points.min(axis=0) - REACH * radius, points.max(axis=0) + REACH * radius
    columns, step = np.ascontiguousarray(points.T), STEP * radius
    if not all(_length(path) < LONGEST * step for path in [*paths, *(led.way for led in colliders)]):  # NaN is no less
        return None
    for led in colliders:
        near = _near(points, led, CELL * radius)
        if near is None:
            return None
        found.update(near)
    centres = np.concatenate([np.zeros((0, 3)), *(_resampled(path, step) for path in paths)])
    centres = centres[((centres >= low) & (centres <= high)).all(axis=1)]
    _, apart = np.unique(np.round(centres / step), axis=0, return_index=True)  # it may go there often
    if len(apart) > MOST:
        return None
    for centre in centres[apart]:
        away = _squares(columns, centre)
        if away[at := int(away.argmin())] <= (REACH * radius) ** 2:
            found.add(at)
    if not 0 < len(found) <= MOST:
        return None
    places = tuple(tuple(points[at].tolist()) for at in sorted(found))
    return Pressed(places, radius, *([] if colliders else _deepest_and_fastest(columns, paths, radius, look)))


def coarser(points: Floats, pressed: Pressed) -> Floats:
    """Return by how much (n,) the spacing of a proxy is larger at points (n, 3) [m] than where it is the finest."""
    columns, away = np.ascontiguousarray(points.T), np.full(len(points), np.inf)
    for place in pressed.places:
        np.minimum(away, _squares(columns, place), out=away)
    return np.clip(1 + GROWTH * (np.sqrt(away) / pressed.radius - FINE), 1.0, FAR)


def share_of(mesh: Mesh, pressed: Pressed) -> float:
    """Return how many vertices a proxy has over one that is everywhere as fine as it is where it is the finest."""
    looked = _looked(mesh)
    areas = mesh.vertex_areas[looked]
    return float((areas / coarser(mesh.rest_positions[looked], pressed) ** 2).sum() / areas.sum())


def _deepest_and_fastest(columns: Floats, paths: list[Floats], radius: float, look: float) -> tuple[float, float]:
    """Return how deep [m] the centres on paths bring fingertips into a surface (3, n), and how fast they are there."""
    low, high, deepest, way = columns.min(axis=1) - radius, columns.max(axis=1) + radius, 0.0, 0.0
    for path in paths:
        near = np.flatnonzero(((path >= low) & (path <= high)).all(axis=1))
        steps = np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1))
        if len(near) and len(steps):  # from or to a place that is near
            way = max(way, float(steps[np.union1d(near[near < len(steps)], near[near > 0] - 1)].max()))
        for at in near[:: -(-len(near) // MOST) or 1]:
            deepest = max(deepest, radius - math.sqrt(float(_squares(columns, path[at]).min())))
    return deepest, way / look if look else math.inf


def _near(points: Floats, led: Led, cell: float) -> list[int] | None:
    """Return points, a cell [m] apart, that a collider comes as near to as that; None where its faces are too many."""
    shifts, faces = _resampled(led.way, cell), led.points[led.triangles]
    low, high = points.min(axis=0) - cell - shifts.max(axis=0), points.max(axis=0) + cell - shifts.min(axis=0)
    while True:
        faces = faces[((faces.max(axis=1) >= low) & (faces.min(axis=1) <= high)).all(axis=1)]
        long = np.linalg.norm(faces - np.roll(faces, 1, axis=1), axis=2).max(axis=1) > cell
        if len(faces) + 3 * int(long.sum()) > FACES:
            return None
        if not long.any():
            break
        middles = (faces[long] + np.roll(faces[long], -1, axis=1)) / 2  # of ab, bc, ca
        corners = [np.stack([faces[long, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)]
        faces = np.concatenate([faces[~long], middles, *corners])
    samples = np.unique(np.round(faces.mean(axis=1) / (cell / 4)), axis=0) * (cell / 4)
    taken = np.unique(np.concatenate([np.unique(np.floor((samples + s) / cell), axis=0) for s in shifts]), axis=0)
    around = {tuple(at) for move in np.ndindex(3, 3, 3) for at in (taken + np.array(move) - 1).tolist()}
    cells, first = np.unique(np.floor(points / cell), axis=0, return_index=True)
    return [int(i) for at, i in zip(cells.tolist(), first, strict=True) if tuple(at) in around]


def _looked(mesh: Mesh) -> Ints:
    used = np.flatnonzero(~mesh.loose)
    return used[:: -(-len(used) // LOOKED)]


def _squares(columns: Floats, place: Floats | Vector) -> Floats:
    """Return the squares (n,) [m2] of the distances of points (3, n) from a place."""
    x, y, z = (column - c for column, c in zip(columns, place, strict=True))
    return x * x + y * y + z * z


def _length(path: Floats) -> float:
    """Return the length of a path (k, 3), NaN or infinite where it has a place that is no number."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1)).sum() + 0 * path.sum())


def _resampled(path: Floats, step: float) -> Floats:
    """Return points on a path (k, 3), so close that none is farther than a step from the next."""
    along = np.append(0.0, np.cumsum(np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1))))
    at = np.linspace(0, along[-1], math.ceil(along[-1] / step) + 1)
    return np.stack([np.interp(at, along, c) for c in path.T], axis=1)
