"""Quantities of a running body that are shown: the surface colours and the profile of a dent."""

from __future__ import annotations

import numpy as np

from .base import Floats, sums_at
from .body import pressure as fill
from .body import shape_matching, springs
from .body.estimate import spread_on
from .body.model import Model
from .body.shape_matching import Pose, fit_pose
from .mesh.surface import Mesh
from .reduction.binding import blend
from .reduction.cells import vertex_normals
from .session import Session

UNITS = {"pressure": "kPa", "depth": "mm", "stretch": "%", "slope": "N/mm", "knee": "mm", "spread": "mm"}
REACH = 2.5  # [tip radius + spread] half the width of a profile


def field(session: Session, name: str) -> Floats:
    """Return a quantity at every vertex of the mesh (n,), in its unit of UNITS.

    Args:
        name: "pressure" of the contacts on the area at rest; "depth" below the surface at rest; mean "stretch" of the
            edges at a vertex; or a constant times its painted map: "slope" (K1), "knee" (x0), and "spread".
    """
    if name == "pressure":
        return pressure(session) / 1e3
    if name == "depth":
        return depth(session) * 1e3
    if name == "stretch":
        return 100 * stretch(session)
    model, maps = session.model, session.model.maps
    shown = [
        {"slope": 1e-3 * each.K1, "knee": 1e3 * each.x0, "spread": 1e3 * spread_on(each, model.mesh.size)}[name]
        for each in model.materials
    ]
    mean = _mean_of_materials(model.mesh, np.array(shown))
    if maps is None:
        return mean
    return mean * {"slope": maps.stiffer, "knee": maps.deeper, "spread": maps.wider}[name]


def at_rest(session: Session) -> Floats:
    """Return the vertices of the shape at rest (n, 3) [m], moved along with the pins or with a free body."""
    rotation, translation = pose_now(session.bent_model(), session.body.positions())
    rest: Floats = session.rest @ rotation.T + translation
    return rest


def depth(session: Session) -> Floats:
    """Return the depth of each vertex (n,) [m] below its place at rest, along the normal at that place."""
    rest = at_rest(session)
    normals = vertex_normals(session.model.mesh.triangles, rest)
    below: Floats = ((rest - session.skin()) * normals).sum(axis=1)
    return below


def stretch(session: Session) -> Floats:
    """Return the mean strain of the edges round each vertex (n,)."""
    ends, n = session.model.mesh.springs, len(session.rest)
    before, now = (np.linalg.norm(x[ends[:, 0]] - x[ends[:, 1]], axis=1) for x in (session.rest, session.skin()))
    strain = now / np.maximum(before, 1e-12) - 1
    count = np.bincount(ends.ravel(), minlength=n)
    return sums_at(ends.ravel(), np.repeat(strain, 2), n) / np.maximum(count, 1)


def pressure(session: Session) -> Floats:
    """Return an estimate of the contact pressure on the surface (n,) [Pa].

    A contact balances the other forces on the vertices that it touches, and these are known. Inertia and damping are
    neglected, so the estimate holds for a body at rest. For a proxy the result is interpolated.
    """
    model, x = session.bent_model(), session.body.positions()
    forces = springs.force(model.springs, x) + fill.force(model.pressure, x) + model.mass * model.gravity[:, None]
    forces += shape_matching.force(model.matching, x, pose_now(model, x))
    outward = (forces.T * vertex_normals(model.mesh.triangles, x.T)).sum(axis=1)
    area = np.maximum(model.mesh.vertex_areas, 1e-12 * model.mesh.size**2)
    pressed = np.where(model.pinned, 0.0, np.maximum(outward, 0.0) / area)
    if session.proxy is None:
        return pressed
    return blend(session.proxy.binding, pressed[:, None])[:, 0]


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
    width = REACH * (tip.radius + max(spread_on(material, mesh.size) for material in session.model.materials))
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


def pose_now(model: Model, x: Floats) -> Pose:
    """Return the pose of the shape at rest for positions (3, n) [m] of a model."""
    if model.free:
        return fit_pose(model.matching.rest, x, model.matching.k1, model.matching.pull)
    if model.rigged:
        return np.eye(3), np.zeros(3)
    pinned = np.flatnonzero(model.pinned & ~model.mesh.loose)
    return fit_pose(model.matching.rest[:, pinned], x[:, pinned], np.ones(len(pinned)))


def _mean_of_materials(mesh: Mesh, values: Floats) -> Floats:
    """Return for each vertex (n,) the area-weighted mean over its faces of a value that belongs to their material."""
    n, area = len(mesh.rest_positions), mesh.triangle_areas
    weighted = np.repeat(values[mesh.triangle_material] * area, 3)
    whole = sums_at(mesh.triangles.ravel(), np.repeat(area, 3), n)
    return sums_at(mesh.triangles.ravel(), weighted, n) / np.maximum(whole, 1e-30)
