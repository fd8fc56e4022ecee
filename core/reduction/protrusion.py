"""How far a mesh stands out of its proxy, and so what distance the proxy keeps from what it meets."""

from __future__ import annotations

import numpy as np

from ..base import Floats, Ints
from ..constants import OFFSET
from ..mesh.nearest import weights_on_face
from ..mesh.surface import Mesh
from .cells import MANY

CLEAR = 90.0  # percent of a mesh that keep at least its own distance
LEAST = 1 / 3  # of the distance that a mesh of such edges holds: nearer, what comes fast is held back by its planes


def held_distance(mesh: Mesh, coarse: Mesh, cells: Ints, spacing: float) -> float:
    """Return the distance [m] that a proxy holds so that its mesh holds its own.

    A proxy of long edges would else be met sooner than the mesh that it moves.

    Args:
        coarse, cells, spacing: of the proxy.
    """
    looked = _looked(mesh)
    out = protrusion(mesh, coarse, cells, looked)
    wanted = OFFSET * float(mesh.rest_lengths.mean()) + max(float(np.percentile(out, CLEAR)), 0.0) / 2
    return float(np.clip(wanted, LEAST * OFFSET * spacing, OFFSET * spacing))


def _looked(mesh: Mesh) -> Ints:
    used = np.flatnonzero(~mesh.loose)
    return used[:: -(-len(used) // MANY)]


def protrusion(mesh: Mesh, proxy: Mesh, cells: Ints, looked: Ints) -> Floats:
    """Return how far vertices `looked` (k,) of a mesh lie outside its proxy at rest [m], negative inside."""
    coarse, corners = proxy.rest_positions, proxy.triangles
    order = np.argsort(corners.ravel(), kind="stable")
    starts = np.searchsorted(corners.ravel()[order], np.arange(len(coarse) + 1))
    seeds = cells[looked]  # the faces round its seed lie over a cell
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
