"""What is pressed where there is no Blender: a cube, or a mesh from a file, in the size of the real object."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from core.base import DimpleError, Floats, Ints
from core.mesh.surface import Mesh, mesh_from_triangles

SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb")


def cube(cells: int, edge: float) -> Mesh:
    """Return a cube with cells x cells squares a side, 6 * cells**2 + 2 vertices."""
    return mesh_from_triangles(*cube_triangles(cells, edge))


def cube_triangles(cells: int, edge: float) -> tuple[Floats, Ints]:
    """Return the positions and triangles of `cube`, its six sides not yet welded."""
    line = np.linspace(-edge / 2, edge / 2, cells + 1)
    u, v = (a.ravel() for a in np.meshgrid(line, line, indexing="ij"))
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (corner[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    side = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    positions: list[Floats] = []
    triangles: list[Ints] = []
    for axis in range(3):
        for sign in (-1, 1):
            plane = np.empty((len(u), 3))
            plane[:, axis], plane[:, (axis + 1) % 3], plane[:, (axis + 2) % 3] = sign * edge / 2, u, v
            triangles.append((side if sign > 0 else side[:, ::-1]) + len(positions) * len(u))
            positions.append(plane)
    return np.concatenate(positions), np.concatenate(triangles)


def load_mesh(path: str | Path, size: float) -> Mesh:
    """Read a mesh, z up, and scale its longest side to a size [m].

    Raises:
        DimpleError: it cannot be read or pressed.
    """
    points, faces = load_triangles(path)
    return mesh_from_triangles(points * (size / mesh_from_triangles(points, faces).size), faces)


def load_triangles(path: str | Path) -> tuple[Floats, Ints]:
    """Read the vertices and triangles of a mesh as they are in a file.

    Raises:
        DimpleError: it cannot be read, or has no faces.
    """
    import trimesh

    if Path(path).suffix.lower() not in SUFFIXES:
        raise DimpleError(f"{path} is none of {', '.join(SUFFIXES)}. Export the mesh as one of them.")
    try:
        loaded = trimesh.load(str(path), force="mesh", process=False)
    except OSError as error:
        raise DimpleError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, NotImplementedError) as error:
        raise DimpleError(f"{path} is damaged, or no mesh: {error}.") from None
    if not isinstance(loaded, trimesh.Trimesh) or not len(loaded.faces):
        raise DimpleError(f"{path} has no faces, so there is nothing to press.")
    return np.asarray(loaded.vertices, np.float64), np.asarray(loaded.faces, np.int64)
