"""The simplest meshes: cube, ball and sheet."""

from __future__ import annotations

import numpy as np

from core.base import Floats, Ints
from core.mesh.surface import Mesh, mesh_from_triangles

Shape = tuple[Floats, Ints]  # points (n, 3) and triangles (t, 3)
SIZE = 0.165  # [m] of the paper's larger cube


def sized(points: Floats, faces: Ints, size: float = SIZE) -> Mesh:
    """Return a mesh whose longest side has a size [m]."""
    return mesh_from_triangles(points * (size / np.ptp(points, axis=0).max()), faces)


def grid(columns: int, rows: int, width: float = 2.0, depth: float = 2.0) -> Shape:
    """Return a flat sheet of columns x rows squares in the plane z = 0, facing up; 1 x 1 is Blender's plane."""
    x, y = np.linspace(-width / 2, width / 2, columns + 1), np.linspace(-depth / 2, depth / 2, rows + 1)
    points = np.stack([a.ravel() for a in (*np.meshgrid(x, y, indexing="ij"), np.zeros((columns + 1, rows + 1)))], 1)
    index = np.arange(len(points)).reshape(columns + 1, rows + 1)
    a, b, c, d = (i.ravel() for i in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def cube(cells: int, edge: float) -> Mesh:
    """Return a cube with cells x cells squares a side, 6 * cells**2 + 2 vertices."""
    return mesh_from_triangles(*cube_triangles(cells, edge))


def cube_triangles(cells: int, edge: float) -> Shape:
    """Return the positions and triangles of `cube`, its six sides not yet welded."""
    flat, side = grid(cells, cells, edge, edge)
    positions: list[Floats] = []
    triangles: list[Ints] = []
    for axis in range(3):
        for sign in (-1, 1):
            plane = np.empty_like(flat)
            plane[:, axis], plane[:, (axis + 1) % 3], plane[:, (axis + 2) % 3] = sign * edge / 2, flat[:, 0], flat[:, 1]
            triangles.append((side if sign > 0 else side[:, ::-1]) + len(positions) * len(flat))
            positions.append(plane)
    return np.concatenate(positions), np.concatenate(triangles)


def box(cells: int) -> Shape:
    """Return a cube of cells x cells squares a side; 1 is Blender's default cube of 8 vertices."""
    mesh = cube(cells, 2.0)
    return mesh.rest_positions, mesh.triangles


def icosphere(subdivisions: int, radius: float = 1.0) -> Shape:
    """Return a sphere of 10 * 4**subdivisions + 2 vertices; Blender calls the same number one more."""
    import trimesh

    made = trimesh.creation.icosphere(subdivisions, radius)
    return np.array(made.vertices), np.array(made.faces, np.int64)
