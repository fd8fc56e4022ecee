"""A virtual indentation: a body at rest under a measuring tip, depth by depth.

A flat punch grips: the surface points under it move with it by prescription. The rest of the body goes to its
equilibrium, and the force on the punch is the sum of the forces on those points. A sphere is a fingertip of a session,
let down slowly.

Each depth also yields how the force depends on the constants c. The energy E at rest obeys F = dE/dx, so
dF/dc = d/dx (dE/dc), with the body left where it is (Hellmann, Feynman). Under a flat punch that is known exactly, knee
and all; elsewhere the energy's slopes dE/dc are smooth, and the difference between two depths will do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..base import Bools, DimpleError, Floats
from ..body import pressure
from ..body.estimate import reach
from ..body.model import Model, State, build_model, forces, initial_state
from ..material import Indenter, Material
from ..mesh.ray import ray_hit
from ..mesh.surface import Mesh, base_vertices
from ..session import Finger, Session
from ..solver.equilibrium import equilibrium

ROWS = 60  # of a virtual press
CLEAR = 0.9  # of the thickness: deeper, the tip meets the far side
SPEED = 0.05  # [m/s] of a sphere between two depths
SETTLING, LISTENING = 0.1, 0.03  # [s] of waiting at a depth, and of taking the mean of the force


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
    pull: (4,) dE/d log of kappa1, kappa2, d0 and membrane_scale [J], without the shape matching under a flat punch.
    slope: (4,) what the shape matching under a flat punch adds to their derivatives in depth [N].
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
    """Press a body to each depth [m] in turn and yield where it rests; the last is where no rest was found, if so.

    Raises:
        DimpleError: the laws have no energy.
    """
    flat = indenter.shape != "sphere"
    model = build_model(
        mesh,
        [material] * (int(mesh.triangle_material.max()) + 1),
        held=(site.held | site.under if flat else site.held)[mesh.source],
    )
    stations = _by_punch(model, site, depths) if flat else _by_sphere(model, indenter.radius, site, depths)
    for station in stations:
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


def _by_punch(model: Model, site: Site, depths: Sequence[float]) -> Iterator[Station]:
    """Move the vertices under the punch; the rest finds its equilibrium."""
    x = model.matching.rest
    for depth in depths:
        moved = x.copy()
        moved[:, site.under] = model.matching.rest[:, site.under] + depth * site.inward[:, None]
        found = equilibrium(model, [], start=moved)
        x = found.positions
        force = -float(site.inward @ forces(model, _at(model, x))[:, site.under].sum(axis=1))
        yield _station(model, site.under, depth, force, x, found.converged)


def _by_sphere(model: Model, radius: float, site: Site, depths: Sequence[float]) -> Iterator[Station]:
    """Go down with a fingertip of a running session, slowly, and wait at each depth."""
    session, at = Session(model), 0.0
    session.set_fingers([_finger(site, 0.0, radius)])
    for depth in depths:
        session.set_fingers([_finger(site, depth, radius)])
        session.step(abs(depth - at) / SPEED + SETTLING)
        frame = session.step(LISTENING)
        force = -float(frame.finger_forces[0] @ site.inward) if len(frame.finger_forces) else math.nan
        x = np.zeros_like(model.mesh.rest_positions)
        x[model.mesh.source] = session.positions()
        whole = frame.finite and math.isfinite(force)
        yield _station(model, np.zeros_like(site.under), depth, force, np.ascontiguousarray(x.T), whole)
        at = depth


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
    """Return the energy's slopes in the logarithms of the constants (4,) [J], and those (4,) [N] under a punch."""
    law, skin = model.matching, model.springs
    d = np.sqrt(((x - law.rest) ** 2).sum(axis=0))
    over = np.maximum(d - law.d0, 0)
    i, j = skin.pairs.T
    stretch = np.sqrt(((x[:, j] - x[:, i]) ** 2).sum(axis=0)) - skin.rest_lengths
    k1, k2, knee = law.k1, law.k2, (law.k2 - law.k1) * law.d0
    bed = np.array([k1 * (d * d - over * over) / 2, k2 * over * over / 2, -knee * over])
    beneath = np.array([k1 * np.minimum(depth, law.d0), k2 * np.maximum(depth - law.d0, 0), -knee * (depth > law.d0)])
    return (
        np.append(bed[:, ~under].sum(axis=1), skin.stiffness @ (stretch * stretch) / 2),
        np.append(beneath[:, under].sum(axis=1), 0.0),
    )
