"""A virtual indentation: a body at rest under a measuring tip, depth by depth.

A flat punch grips: the surface points under it are pins that go down with it, and the force on it is the sum of the
forces on them. Its body is critically damped, so that it comes to rest within a few ticks at each depth. A sphere is a
fingertip and goes on down. Either body is light, so that it follows.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import FINGER_TRAVEL, Bools, DimpleError, Floats
from ..body import pressure
from ..body.estimate import estimate, reach, skin_compliance
from ..body.forces import forces
from ..body.model import Model, State, build_model, initial_state
from ..material import Indenter, Material
from ..mesh.ray import ray_hit
from ..mesh.surface import Mesh, base_vertices
from ..session import Finger, Session
from ..steps import result_of

ROWS = 60  # of a virtual press
RIM = 1 / 3  # of an edge: the rim of a punch holds the edges that cross it as if it were so much wider
CLEAR = 0.9  # of the thickness: deeper, the tip meets the far side
RATE = 500.0  # [1/s] at which a body with the mass and damping of a virtual press settles
MOVING, SETTLING = 0.004, 0.004  # [s] between two depths of a flat tip, and of rest there
# [s] between two depths of a round tip, and of taking the mean of its force: friction remembers the way, so it sinks
# as a fingertip does, in a body as damped as the material is, at least so much
SINKING, LISTENING, LEAST_DAMPING = 0.010, 0.004, 0.2
LARGEST_PART = 0.5  # of the depth: what the skin of a solid gives under a flat tip


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Where a body is pressed.

    point: (3,) on the surface at rest [m].
    inward: (3,) unit vector of the way the tip goes.
    thickness: distance to the far side [m], inf where there is none.
    under: (n,) vertices under a flat punch.
    pinned: (n,) vertices.
    others: further places, with which a round tip is identified together: the mean of the forces is the measured one.
    """

    point: Floats
    inward: Floats
    thickness: float
    under: Bools
    pinned: Bools
    others: tuple[Site, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """A body at rest under a tip.

    depth: of the tip below the surface at rest [m].
    force: on the tip [N].
    volume_change: as a share.
    positions: (3, n) [m].
    found: whether there is rest at this depth.
    """

    depth: float
    force: float
    volume_change: float
    positions: Floats
    found: bool


def find_site(
    mesh: Mesh,
    indenter: Indenter,
    *,
    pinned: Bools | None = None,
    above: Sequence[float] | None = None,
    inward: Sequence[float] = (0.0, 0.0, -1.0),
) -> Site:
    """Find where a tip meets a body.

    Args:
        pinned: (N,) input vertices; where they are too few to hold a body, its base stays.
        above: (3,) [m] a point on the way in; left out: over the middle of the body.
        inward: (3,) way the tip goes.

    Raises:
        DimpleError: the tip misses the body, or would press what is pinned.
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
    if pinned is not None:
        stay[mesh.source] = pinned
    if np.linalg.matrix_rank(x[stay] - x[stay].mean(axis=0) if stay.any() else np.zeros((1, 3)), 1e-3 * mesh.size) < 2:
        stay[mesh.source] = base_vertices(mesh, up=tuple(-way))
    rim = RIM * float(mesh.rest_lengths.mean()) if indenter.shape == "punch" else 0.0
    under = _under(mesh, point, way, reach(indenter, mesh.size) + rim)
    if (under & stay).any():
        raise DimpleError("The tip stands on vertices that are pinned. Press elsewhere, or pin fewer.")
    return Site(
        point=point, inward=way, thickness=beyond[0] if beyond else math.inf, under=under, pinned=stay
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
    session = set_up(mesh, material, indenter, site)
    before = 0.0
    for depth in depths:
        station = go_down(session, indenter, site, before, depth)
        yield station
        if not station.found:
            return
        before = depth


def set_up(mesh: Mesh, material: Material, indenter: Indenter, site: Site) -> Session:
    """Return a session of a body under a tip that just touches it, without a pressure: as the object was measured."""
    constants = estimate(material, mesh.size)
    mass = constants.kappa1 * float(mesh.triangle_areas.sum()) / RATE**2
    under = _gripped(indenter, site)
    damping = 1.0 if under.any() else max(material.damping_ratio, LEAST_DAMPING)
    light = replace(material, constants=constants, mass=mass, density=None, damping_ratio=damping, pressure=0.0)
    model = build_model(
        replace(mesh, loose=mesh.loose | under),  # pins that go down must not carry the shape at rest along
        [light] * (int(mesh.triangle_material.max()) + 1),
        pinned=(site.pinned | under)[mesh.source],
    )
    session = Session(model)
    put_back(session, indenter, site)
    return session


def put_back(session: Session, indenter: Indenter, site: Site) -> None:
    """Put a body back to rest, under a tip that just touches it."""
    session.reset()
    if not _gripped(indenter, site).any():
        session.set_fingers([_finger(site, 0.0, indenter.radius)])


def go_down(session: Session, indenter: Indenter, site: Site, before: float, depth: float) -> Station:
    """Bring a tip from one depth [m] to another, or to the same to wait for rest once more."""
    return result_of(going_down(session, indenter, site, before, depth))


def going_down(
    session: Session, indenter: Indenter, site: Site, before: float, depth: float
) -> Generator[float, None, Station]:
    """Go down in steps of some milliseconds each.

    Yields:
        the share that is done, at the least.

    Returns:
        where the body rests.
    """
    model, under = session.model, _gripped(indenter, site)
    ticks = math.ceil(abs(depth - before) / (FINGER_TRAVEL * indenter.radius))
    if under.any():
        places = model.mesh.rest_positions + depth * np.outer(under, site.inward)
        session.set_pins(places[model.mesh.source])
        if depth != before:
            session.step(max(MOVING, 2 * ticks * session.clock.tick))
            yield 0.3
        frame = session.step(SETTLING)
        force = -float(site.inward @ forces(model, _at(model, session.body.positions()))[:, under].sum(axis=1))
    else:
        steps = max(round(SINKING / session.clock.tick), ticks) if depth != before else 1
        session.set_fingers([_finger(site, depth, indenter.radius)])
        session.step(steps * session.clock.tick)
        yield 0.7
        frame = session.step(LISTENING)
        force = -float(frame.finger_forces[0] @ site.inward) if frame.finite and len(frame.finger_forces) else math.nan
    x = session.body.positions()
    volume = pressure.volume(model.pressure, x) if model.pressure.fill == "none" else frame.volume
    return Station(
        depth=depth, force=force, volume_change=volume / model.mesh.volume - 1 if model.mesh.pressurable else 0.0,
        positions=x, found=frame.finite and math.isfinite(force),
    )  # fmt: skip


def press_rows(
    mesh: Mesh, material: Material, indenter: Indenter, site: Site, deepest: float, *, rows: int = ROWS
) -> Iterator[tuple[float, float]]:
    """Yield depth [m] and force [N] of a virtual press from the touch on, as an instrument would.

    It ends before the far side, and where the body finds no rest.
    """
    yield 0.0, 0.0
    deepest, given = min(deepest, CLEAR * site.thickness), gives_way(material, indenter, mesh.size)
    depths = (deepest - given * material.law(deepest)) * np.arange(1, rows) / (rows - 1)
    for station in press(mesh, material, indenter, site, depths.tolist()):
        if station.found:
            yield station.depth + given * station.force, station.force


def gives_way(material: Material, indenter: Indenter, size: float) -> float:
    """Return how far the skin of a solid gives way under a flat tip [m/N]; 0 for all else.

    Vertices under a flat tip go down with it, so in a virtual press their skin has no part: it comes in series.
    """
    if material.fill != "solid" or indenter.shape == "sphere":
        return 0.0
    compliance = skin_compliance(material, estimate(replace(material, constants=None), size))
    return min(compliance / (math.pi * reach(indenter, size) ** 2), LARGEST_PART / max(material.K1, material.K2))


def _gripped(indenter: Indenter, site: Site) -> Bools:
    """Return the vertices (n,) that go down with the tip: none with a sphere."""
    return site.under if indenter.shape != "sphere" else np.zeros_like(site.under)


def _finger(site: Site, depth: float, radius: float) -> Finger:
    x, y, z = (site.point + (depth - radius) * site.inward).tolist()
    return Finger((x, y, z), radius)


def _at(model: Model, positions: Floats) -> State:
    state = initial_state(model)
    state.positions[:] = positions
    return state
