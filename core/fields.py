"""Quantities of a running body that are shown: the surface colours."""

from __future__ import annotations

import numpy as np

from .base import Floats, sums_at
from .body import pressure as fill
from .body import shape_matching, springs
from .body.model import Model
from .body.shape_matching import Pose, fit_pose
from .reduction.binding import blend
from .reduction.cells import vertex_normals
from .session import Session

UNITS = {"pressure": "kPa", "depth": "mm", "stretch": "%"}


def field(session: Session, name: str) -> Floats:
    """Return a quantity at every vertex of the mesh (n,), in its unit of UNITS.

    Args:
        name: "pressure" of the contacts on the area at rest; "depth" below the surface at rest; or mean "stretch" of
            the edges at a vertex.
    """
    if name == "pressure":
        return pressure(session) / 1e3
    if name == "depth":
        return depth(session) * 1e3
    return 100 * stretch(session)


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


def pose_now(model: Model, x: Floats) -> Pose:
    """Return the pose of the shape at rest for positions (3, n) [m] of a model."""
    if model.free:
        return fit_pose(model.matching.rest, x, model.matching.k1, model.matching.pull)
    if model.rigged:
        return np.eye(3), np.zeros(3)
    pinned = np.flatnonzero(model.pinned & ~model.mesh.loose)
    return fit_pose(model.matching.rest[:, pinned], x[:, pinned], np.ones(len(pinned)))
