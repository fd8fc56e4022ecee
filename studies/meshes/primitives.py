"""Meshes as artists bring them: Blender's primitives as they come and subdivided, and kinds that are hard to simulate.

Each is one largest dimension long, which its user chooses.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from core.base import Floats
from core.mesh.surface import Mesh
from studies.meshes import bodies
from studies.meshes.simple import SIZE, Shape, box, grid, icosphere, sized

FINENESS = (5, 10, 18)  # of the shapes of `bodies`: about 150, 600 and 2,000 vertices
SHAPES = (
    bodies.ball, bodies.blob, bodies.head, bodies.scan, bodies.box, bodies.slab, bodies.torus, bodies.capsule,
    bodies.cup, bodies.star, bodies.cushion, bodies.banana, bodies.wedge, bodies.cone, bodies.dumbbell,
)  # fmt: skip


def makers() -> dict[str, Callable[[], Mesh]]:
    """Return what makes each mesh, by name: the shapes of `bodies`, PRIMITIVES and HARD ones."""
    made: dict[str, Callable[[], Mesh]] = {
        f"{shape.__name__} {fine}": partial(shape, fine, SIZE) for shape in SHAPES for fine in FINENESS
    }
    return made | {name: partial(_sized, shape) for name, shape in (*PRIMITIVES.items(), *HARD.items())}


def _sized(shape: Callable[[], Shape]) -> Mesh:
    return sized(*shape())


def turned(outline: Floats, sections: int) -> Shape:
    """Return what an outline (n, 2) of distances from the axis and heights becomes, turned round the axis."""
    import trimesh

    made = trimesh.creation.revolve(outline, sections=sections)
    return np.array(made.vertices), np.array(made.faces)


def uv_sphere(segments: int, rings: int) -> Shape:
    """Return a sphere of meridians and parallels."""
    turn = np.linspace(0, np.pi, rings + 1)
    return turned(np.stack([np.sin(turn), -np.cos(turn)], axis=1).clip([0, -1], None), segments)


def tube(segments: int, rows: int, rings: int, *, top: float = 1.0) -> Shape:
    """Return a cylinder, or with a top of 0 a cone: rows along its height, and rings in its lids, 1: a fan."""
    lid, up = np.linspace(0, 1, rings + 1)[:-1], np.linspace(0, 1, rows + 1)
    lower = [(r, -1.0) for r in lid]
    upper = [(top * r, 1.0) for r in lid[::-1]] if top else []
    side = [(1 - (1 - top) * s, 2 * s - 1) for s in up]
    return turned(np.array(lower + side + upper), segments)


def torus(major: int, minor: int) -> Shape:
    """Return a torus, its tube a quarter as thick as its ring is wide, as Blender's."""
    import trimesh

    made = trimesh.creation.torus(1.0, 0.25, major_sections=major, minor_sections=minor)
    return np.array(made.vertices), np.array(made.faces)


def remeshed(subdivisions: int, *, shift: float = 0.3, seed: int = 4) -> Shape:
    """Return a sphere of points that are not even: shifted along it by a share of their spacing, joined anew."""
    from scipy.spatial import ConvexHull

    points, _ = icosphere(subdivisions)
    rng = np.random.default_rng(seed)
    spacing = np.sqrt(4 * np.pi / len(points) * 2 / np.sqrt(3))
    points = points + shift * spacing * rng.normal(size=points.shape)
    points /= np.linalg.norm(points, axis=1)[:, None]
    faces = ConvexHull(points).simplices.astype(np.int64)
    inward = np.linalg.det(points[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def rotated(shape: Shape, *, seed: int = 8) -> Shape:
    """Return a shape turned at random: its triangles lie otherwise under a tip that comes from above."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return shape[0] @ (turn * np.sign(np.linalg.det(turn))).T, shape[1]


def stretched(shape: Shape, *factors: float) -> Shape:
    """Return a shape with its axes scaled."""
    return shape[0] * np.array(factors), shape[1]


def joined(*shapes: Shape) -> Shape:
    """Return several pieces as one mesh that share nothing."""
    starts = np.cumsum([0, *(len(points) for points, _ in shapes)])
    faces = [faces + start for (_, faces), start in zip(shapes, starts, strict=False)]
    return np.concatenate([points for points, _ in shapes]), np.concatenate(faces)


def moved(shape: Shape, *way: float) -> Shape:
    """Return a shape moved along."""
    return shape[0] + np.array(way), shape[1]


def bent(shape: Shape) -> Shape:
    """Return a sheet bent to a wave."""
    points, faces = shape
    return points + np.stack([0 * points[:, 0], 0 * points[:, 0], 0.2 * np.sin(3 * points[:, 0])], axis=1), faces


PRIMITIVES: dict[str, Callable[[], Shape]] = {
    "default cube": lambda: box(1),
    "cube subdivided once": lambda: box(2),
    "cube subdivided twice": lambda: box(4),
    "cube subdivided 3 times": lambda: box(8),
    "cube subdivided 4 times": lambda: box(16),
    "cube of 30 squares": lambda: box(30),
    "UV sphere 32 x 16": lambda: uv_sphere(32, 16),
    "UV sphere 64 x 32": lambda: uv_sphere(64, 32),
    "UV sphere 16 x 8": lambda: uv_sphere(16, 8),
    "ico sphere 2": lambda: icosphere(1),
    "ico sphere 3": lambda: icosphere(2),
    "ico sphere 4": lambda: icosphere(3),
    "ico sphere 5": lambda: icosphere(4),
    "cylinder": lambda: tube(32, 1, 1),
    "cylinder of 8 rows": lambda: tube(32, 8, 1),
    "cylinder of 16 rows and 6 rings": lambda: tube(32, 16, 6),
    "cone": lambda: tube(32, 1, 1, top=0.0),
    "cone of 8 rows": lambda: tube(32, 8, 1, top=0.0),
    "cone of 16 rows and 6 rings": lambda: tube(32, 16, 6, top=0.0),
    "torus 48 x 12": lambda: torus(48, 12),
    "torus 96 x 24": lambda: torus(96, 24),
    "plane": lambda: grid(1, 1),
    "grid 10 x 10": lambda: grid(10, 10),
    "grid 32 x 32": lambda: grid(32, 32),
}
HARD: dict[str, Callable[[], Shape]] = {
    "tetrahedron": lambda: (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), np.array(
        [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])),
    "uneven ball of 642": lambda: remeshed(3),
    "uneven ball of 2,562": lambda: remeshed(4),
    "very uneven ball of 642": lambda: remeshed(3, shift=1.0),
    "very uneven ball of 2,562": lambda: remeshed(4, shift=1.0),
    "cube of slivers 1:10": lambda: stretched(box(10), 1, 1, 0.1),
    "UV sphere 128 x 16": lambda: uv_sphere(128, 16),
    "UV sphere 256 x 16": lambda: uv_sphere(256, 16),
    "needle": lambda: stretched(icosphere(3), 0.08, 0.08, 1),
    "pancake": lambda: stretched(icosphere(3), 1, 1, 0.08),
    "wavy sheet of 32 x 32": lambda: bent(grid(32, 32)),
    "standing sheet": lambda: (grid(16, 16)[0][:, [2, 0, 1]], grid(16, 16)[1]),
    "letter": lambda: _letter(),
    "wall across a box": lambda: _walled(),
    "Moebius strip": lambda: _moebius(60, 6),
    "ring of a sheet": lambda: _annulus(48, 6),
    "rod 1:20": lambda: stretched(tube(16, 60, 2), 0.05, 0.05, 1),
    "icosahedron": lambda: icosphere(0),
    "UV sphere 8 x 4": lambda: uv_sphere(8, 4),
    "box in a box, its wall thin": lambda: joined(box(10), _inside_out(stretched(box(9), 0.9, 0.9, 0.9))),
    "uneven ball of 10,242": lambda: remeshed(5),
    "open half ball": lambda: _half(icosphere(4)),
    "two balls, one on the other": lambda: joined(icosphere(3), moved(icosphere(3), 0, 0, 2.02)),
    "two balls beside each other": lambda: joined(icosphere(3), moved(icosphere(3), 2.1, 0, 0)),
    "two balls that pass through each other": lambda: joined(icosphere(3), moved(icosphere(3), 0.5, 0, 0.7)),
    "ball in a ball": lambda: joined(icosphere(3), stretched(icosphere(2), 0.5, 0.5, 0.5)),
    "soup": lambda: _soup(icosphere(3)),
}  # fmt: skip


def _half(shape: Shape) -> Shape:
    points, faces = shape
    kept = faces[(points[faces, 2] > -0.05).all(axis=1)]
    used, again = np.unique(kept, return_inverse=True)
    return points[used], again.reshape(-1, 3)


def _soup(shape: Shape) -> Shape:
    """Return every triangle with corners of its own, half of them turned inside out."""
    points, faces = shape
    faces = faces.copy()
    faces[::2] = faces[::2, ::-1]
    return points[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def _inside_out(shape: Shape) -> Shape:
    return shape[0], shape[1][:, ::-1]


def _letter() -> Shape:
    """Return a T of the default text, extruded: few vertices and long thin faces."""
    outline = [(-3, 3), (-3, 2), (-0.5, 2), (-0.5, -3), (0.5, -3), (0.5, 2), (3, 2), (3, 3)]
    lid = np.array([(0, 1, 2), (0, 2, 5), (2, 3, 4), (2, 4, 5), (0, 5, 7), (5, 6, 7)])
    points = np.array([(x, y, z) for z in (0.0, 0.8) for x, y in outline])
    around = np.arange(8)
    sides = np.stack([around, around + 8, np.roll(around, -1)], 1), np.stack(
        [np.roll(around, -1), around + 8, np.roll(around, -1) + 8], 1)  # fmt: skip
    return points[:, [0, 2, 1]], np.concatenate([lid, 8 + lid[:, ::-1], *sides])


def _walled() -> Shape:
    """Return a box with a wall across it, whose edges join three faces."""
    points, faces = box(8)
    line = np.linspace(-1, 1, 9)
    wall, cells = grid(8, 8)
    wall = np.stack([0 * wall[:, 0] + line[4], wall[:, 0], wall[:, 1]], axis=1)
    return joined((points, faces), (wall, cells))


def _moebius(around: int, across: int) -> Shape:
    """Return a strip that has one side only."""
    u, v = (a.ravel() for a in np.meshgrid(np.arange(around), np.linspace(-1, 1, across + 1), indexing="ij"))
    turn = 2 * np.pi * u / around
    radius = 1 + 0.3 * v * np.cos(turn / 2)
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.3 * v * np.sin(turn / 2)], axis=1)
    corner = np.arange(around * (across + 1)).reshape(around, -1)
    corner = np.concatenate([corner, corner[:1, ::-1]])
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    return points, np.concatenate([np.stack(three, -1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))])


def _annulus(around: int, across: int) -> Shape:
    """Return a flat sheet with a hole."""
    turn, r = (a.ravel() for a in np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0.4, 1, across + 1),
                                              indexing="ij"))  # fmt: skip
    corner = np.arange(around * (across + 1)).reshape(around, -1)
    corner = np.concatenate([corner, corner[:1]])
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.concatenate([np.stack(three, -1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))])
    return np.stack([r * np.cos(turn), r * np.sin(turn), 0 * r], axis=1), faces[:, ::-1]
