"""A virtual indentation: a body at rest under a measuring tip, depth by depth.

A flat punch grips: the surface points under it are pins that go down with it, and the force on it is the sum of the
forces on them. A sphere is a fingertip. Either goes down in a session whose body is light and critically damped, so
that it comes to rest within a few ticks at each depth.

Each depth also yields how the force depends on the constants c. The energy E at rest obeys F = dE/dx, so
dF/dc = d/dx (dE/dc), with the body left where it is (Hellmann, Feynman). Under a flat punch that is known exactly, knee
and all; elsewhere the energy's slopes dE/dc are smooth, and the difference between two depths will do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import FINGER_TRAVEL, Bools, DimpleError, Floats
from ..body import pressure
from ..body.estimate import estimate, reach
from ..body.model import Model, State, build_model, forces, initial_state
from ..material import Indenter, Material
from ..mesh.ray import ray_hit
from ..mesh.surface import Mesh, base_vertices
from ..session import Finger, Session

ROWS = 60  # of a virtual press
CLEAR = 0.9  # of the thickness: deeper, the tip meets the far side
RATE = 500.0  # [1/s] at which a body with the mass and damping of a virtual press settles
MOVING, SETTLING = 0.006, 0.01  # [s] between two depths, and of rest there
LISTENING = 0.005  # [s] of taking the mean of a reaction
ROUND = 4  # times as slow goes a sphere: what it touches changes, and friction holds on


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Where a body is pressed.

    point: (3,) on the surface at rest [m].
    inward: (3,) unit vector of the way the tip goes.
    thickness: distance to the far side [m], inf where there is none.
    under: (n,) vertices under a flat punch.
    held: (n,) vertices that stay.
    """

    point: Floats
    inward: Floats
    thickness: float
    under: Bools
    held: Bools


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """A body at rest under a tip.

    depth: of the tip below the surface at rest [m].
    force: on the tip [N].
    volume_change: as a share.
    pull: (3,) dE/d log of kappa1, kappa2 and d0 [J], without the bed under a flat punch.
    slope: (3,) what the bed under a flat punch adds to their derivatives in depth [N].
    positions: (3, n) [m].
    found: whether there is rest at this depth.
    """

    depth: float
    force: float
    volume_change: float
    pull: Floats
    slope: Floats
    positions: Floats
    found: bool


def find_site(
    mesh: Mesh,
    indenter: Indenter,
    *,
    held: Bools | None = None,
    above: Sequence[float] | None = None,
    inward: Sequence[float] = (0.0, 0.0, -1.0),
) -> Site:
    """Find where a tip meets a body.

    Args:
        held: (N,) input vertices that stay; where they are too few to hold a body, its base stays.
        above: (3,) [m] a point on the way in; left out: over the middle of the body.
        inward: (3,) way the tip goes.

    Raises:
        DimpleError: the tip misses the body, or would press what is held.
    """
    x = mesh.rest_positions
    way = np.asarray(inward, np.float64) / np.linalg.norm(inward)
    used = x[~mesh.loose]
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    start = (middle if above is None else np.asarray(above, np.float64)) - 2 * mesh.size * way
    hit = ray_hit(tuple(start), tuple(way), x, mesh.triangles)
    if hit is None:
        raise DimpleError("The tip misses the object. Move it over the place to be pressed.")
    point = np.array(hit[1])
    beyond = ray_hit(tuple(point + 1e-6 * mesh.size * way), tuple(way), x, mesh.triangles)
    stay = np.zeros(len(x), bool)
    if held is not None:
        stay[mesh.source] = held
    if np.linalg.matrix_rank(x[stay] - x[stay].mean(axis=0) if stay.any() else np.zeros((1, 3)), 1e-3 * mesh.size) < 2:
        stay[mesh.source] = base_vertices(mesh, up=tuple(-way))
    under = _under(mesh, point, way, reach(indenter, mesh.size))
    if (under & stay).any():
        raise DimpleError("The tip stands on vertices that are pinned. Press elsewhere, or pin fewer.")
    return Site(
        point=point, inward=way, thickness=beyond[0] if beyond else math.inf, under=under, held=stay
    )  # fmt: skip


def _under(mesh: Mesh, point: Floats, way: Floats, radius: float) -> Bools:
    """Return the vertices (n,) under a flat punch: within its radius, near its face; at least the nearest."""
    offset = mesh.rest_positions - point
    along = offset @ way
    aside = np.linalg.norm(offset - along[:, None] * way, axis=1)
    under = (aside <= radius * (1 + 1e-6)) & (np.abs(along) <= radius) & ~mesh.loose
    if not under.any():
        under[np.where(mesh.loose, np.inf, np.linalg.norm(offset, axis=1)).argmin()] = True
    return under


def press(mesh: Mesh, material: Material, indenter: Indenter, site: Site, depths: Sequence[float]) -> Iterator[Station]:
    """Press a body to each depth [m] in turn and yield where it rests; the last is where no rest was found, if so."""
    flat = indenter.shape != "sphere"
    constants = estimate(material, mesh.size)
    mass = constants.kappa1 * float(mesh.triangle_areas.sum()) / RATE**2
    light = replace(material, constants=constants, mass=mass, density=None, damping_ratio=1.0)
    under = site.under if flat else np.zeros_like(site.under)
    model = build_model(
        replace(mesh, loose=mesh.loose | under),  # pins that go down must not carry the shape at rest along
        [light] * (int(mesh.triangle_material.max()) + 1),
        held=(site.held | under)[mesh.source],
    )
    for station in _stations(model, indenter, site, under, depths):
        yield station
        if not station.found:
            return


def press_rows(
    mesh: Mesh, material: Material, indenter: Indenter, site: Site, deepest: float, *, rows: int = ROWS
) -> Iterator[tuple[float, float]]:
    """Yield depth [m] and force [N] of a virtual press from the touch on, as an instrument would.

    It ends before the far side, and where the body finds no rest.
    """
    yield 0.0, 0.0
    deepest = min(deepest, CLEAR * site.thickness)
    depths = deepest * np.arange(1, rows) / (rows - 1)
    for station in press(mesh, material, indenter, site, depths.tolist()):
        if station.found:
            yield station.depth, station.force


def _stations(
    model: Model, indenter: Indenter, site: Site, under: Bools, depths: Sequence[float]
) -> Iterator[Station]:
    session, rest = Session(model), model.mesh.rest_positions
    flat, source = bool(under.any()), model.mesh.source
    if not flat:
        session.set_fingers([_finger(site, 0.0, indenter.radius)])
    at = 0.0
    for depth in depths:
        if flat:
            session.set_held((rest + depth * np.outer(under, site.inward))[source])
            session.step(MOVING)
        else:
            session.set_fingers([_finger(site, depth, indenter.radius)])
            ticks = abs(depth - at) / (FINGER_TRAVEL * indenter.radius)
            session.step(max(ROUND * MOVING, 2 * ticks * session.tick))
        session.step(SETTLING if flat else ROUND * SETTLING)
        frame, at = session.step(LISTENING), depth
        x = session.body.positions()
        if flat:
            force = -float(site.inward @ forces(model, _at(model, x))[:, under].sum(axis=1))
        else:
            force = -float(frame.finger_forces[0] @ site.inward) if len(frame.finger_forces) else math.nan
        yield _station(model, under, depth, force, x, frame.finite and math.isfinite(force))


def _finger(site: Site, depth: float, radius: float) -> Finger:
    x, y, z = (site.point + (depth - radius) * site.inward).tolist()
    return Finger((x, y, z), radius)


def _station(model: Model, under: Bools, depth: float, force: float, x: Floats, found: bool) -> Station:
    volume, _ = pressure.volume_and_gradient(model.pressure, x)
    change = volume / model.mesh.volume - 1 if model.mesh.pressurable else 0.0
    pull, slope = _pull(model, under, x, depth)
    return Station(
        depth=depth, force=force, volume_change=change, pull=pull, slope=slope, positions=x, found=found
    )  # fmt: skip


def _at(model: Model, positions: Floats) -> State:
    state = initial_state(model)
    state.positions[:] = positions
    return state


def _pull(model: Model, under: Bools, x: Floats, depth: float) -> tuple[Floats, Floats]:
    """Return the energy's slopes in the logarithms of the constants (3,) [J], and those (3,) [N] under a punch."""
    law = model.matching
    d = np.sqrt(((x - law.rest) ** 2).sum(axis=0))
    over = np.maximum(d - law.d0, 0)
    i, j = law.pairs.T
    k1, k2, knee = law.k1, law.k2, (law.k2 - law.k1) * law.d0
    bed = np.array([k1 * (d * d - over * over) / 2, k2 * over * over / 2, -knee * over])
    u = x - law.rest
    joined = float(law.tension @ ((u[:, i] - u[:, j]) ** 2).sum(axis=0)) / 2  # T goes with kappa1
    beneath = np.array([k1 * np.minimum(depth, law.d0), k2 * np.maximum(depth - law.d0, 0), -knee * (depth > law.d0)])
    return bed[:, ~under].sum(axis=1) + [joined, 0, 0], beneath[:, under].sum(axis=1)
