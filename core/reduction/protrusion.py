"""How far a mesh stands out of its proxy: in contact it is the proxy's surface that touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base import Floats
from ..body.proximity import OFFSET, weights_on_face
from ..mesh.surface import Mesh
from .planner import Plan
from .proxy import Proxy

LOOKED = 20_000  # vertices of a finer mesh that are looked at
SEEN = 1e-5  # [m] that can be seen


def in_contact(mesh: Mesh, chosen: Plan) -> Plan:
    """Return a plan whose reason says how far a mesh that a proxy moves may overlap what it meets."""
    if chosen.proxy is None:
        return chosen
    # the proxy keeps this distance from what it meets, which keeps one too
    apart = OFFSET * float(chosen.proxy.model.mesh.rest_lengths.mean())
    overlap = float(protrusion(mesh, chosen.proxy).max()) - apart
    message = f"In contact the mesh shown may overlap by up to {1e3 * overlap:.2g} mm."
    if overlap < SEEN:
        message = "In contact it is the proxy that touches; the mesh shown stays clear."
    return replace(chosen, reason=f"{chosen.reason} {message}")


def protrusion(mesh: Mesh, proxy: Proxy) -> Floats:
    """Return how far vertices (k,) of a mesh, spread over it, lie outside its proxy at rest [m], negative inside."""
    used = np.flatnonzero(~mesh.loose)
    looked = used[:: -(-len(used) // LOOKED)]
    coarse, corners = proxy.model.mesh.rest_positions, proxy.model.mesh.triangles
    order = np.argsort(corners.ravel(), kind="stable")
    starts = np.searchsorted(corners.ravel()[order], np.arange(len(coarse) + 1))
    seeds = proxy.cells[looked]  # the faces round its seed lie over a cell
    counts = np.diff(starts)[seeds]
    first = np.cumsum(counts) - counts
    faces = order[np.arange(counts.sum()) + np.repeat(starts[seeds] - first, counts)] // 3
    a, b, c = (coarse[corners[faces, k]] for k in range(3))
    points = np.repeat(mesh.rest_positions[looked], counts, axis=0)
    shares = weights_on_face(points, a, b, c)
    way = points - shares[:, :1] * a - shares[:, 1:2] * b - shares[:, 2:] * c
    squares, normals = (way**2).sum(axis=1), np.cross(b - a, c - a)
    at = np.flatnonzero(squares == np.repeat(np.minimum.reduceat(squares, first), counts))
    _, one = np.unique(np.repeat(np.arange(len(looked)), counts)[at], return_index=True)
    at = at[one]
    outward = normals[at] / np.maximum(np.linalg.norm(normals[at], axis=1), 1e-30)[:, None]
    found: Floats = (way[at] * outward).sum(axis=1)
    return found
