"""Shapes that several tests press, each written out so that what is expected of it is known beforehand."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from core.base import Bools, Floats, Ints
from core.session import Session
from studies.reference.rigid import rotation

Shape = tuple[Floats, Ints]
REAL = ("bunny.ply", "not_convex.obj", "soup.stl", "teapot.stl")  # scans and exports as they come
BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data" / "meshes"
TETRAHEDRON: Shape = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
)  # volume 1/6, facing outward


def joined(*shapes: Shape) -> Shape:
    """Put shapes into one mesh, side by side in the arrays, sharing nothing."""
    starts = np.cumsum([0, *(len(points) for points, _ in shapes)])
    return (
        np.concatenate([points for points, _ in shapes]),
        np.concatenate([faces + start for (_, faces), start in zip(shapes, starts, strict=False)]),
    )


def soup(shape: Shape) -> Shape:
    """Give every triangle corners of its own."""
    points, faces = shape
    return points[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def ball(subdivisions: int = 1, radius: float = 1.0) -> Shape:
    """Return an icosphere of 10 * 4**subdivisions + 2 vertices."""
    import trimesh

    sphere = trimesh.creation.icosphere(subdivisions, radius)
    return np.array(sphere.vertices), np.array(sphere.faces)


def block(size: Sequence[float], at: Sequence[float], turn: Sequence[float] = (0.0, 0.0, 0.0)) -> Shape:
    """Return a box, turned about a vector by its length."""
    import trimesh

    box = trimesh.creation.box(size)
    return np.array(box.vertices) @ rotation(np.array(turn)).T + at, np.array(box.faces)


def sheet(cells: int = 4, edge: float = 1.0) -> Shape:
    """Return a flat square of cells x cells squares in the plane z = 0, facing up."""
    line = np.linspace(-edge / 2, edge / 2, cells + 1)
    x, y = (a.ravel() for a in np.meshgrid(line, line, indexing="ij"))
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (index[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    return np.stack([x, y, 0 * x], axis=1), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def plate(filled: Bools, edge: float, thickness: float) -> Shape:
    """Return a plate of square cells, those in `filled` (k, k), the others being holes; it lies on z = 0."""
    k, (i, j), beside = len(filled) + 1, np.nonzero(filled), np.pad(filled, 1)
    a, b, c, d = ((i + x) * k + j + y for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    up, quads = k * k, [np.stack([a, d, c, b], axis=1), np.stack([a, b, c, d], axis=1) + k * k]
    for p, q, x, y in ((d, a, -1, 0), (b, c, 1, 0), (a, b, 0, -1), (c, d, 0, 1)):
        wall = np.stack([p, q, q + up, p + up], axis=1)
        quads.append(wall[~beside[i + 1 + x, j + 1 + y]])
    corners, faces = np.unique(np.concatenate(quads)[:, [0, 1, 2, 0, 2, 3]], return_inverse=True)
    level, x, y = np.unravel_index(corners, (2, k, k))
    return np.stack([edge * x, edge * y, thickness * level], axis=1), faces.reshape(-1, 3)


def hemisphere(segments: int = 16, rings: int = 8, radius: float = 1.0) -> Shape:
    """Return the upper half of a ball of `segments` meridians, open below, facing outward."""
    height = np.arange(rings) * np.pi / 2 / rings
    turn = np.arange(segments) * 2 * np.pi / segments
    points = [(np.cos(h) * np.cos(t), np.cos(h) * np.sin(t), np.sin(h)) for h in height for t in turn]
    faces = []
    for r in range(rings - 1):
        for s in range(segments):
            a, b = r * segments + s, r * segments + (s + 1) % segments
            faces += [(a, b, b + segments), (a, b + segments, a + segments)]
    top, last = len(points), (rings - 1) * segments
    faces += [(last + s, last + (s + 1) % segments, top) for s in range(segments)]
    return radius * np.array([*points, (0, 0, 1)]), np.array(faces)


def fan() -> Shape:
    """Return a cone of 20 triangles round one tip: more neighbours than a ring has room for."""
    turn = np.arange(20) * 2 * np.pi / 20
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    return np.concatenate([rim, [[0, 0, 1.0], [0, 0, -1.0]]]), np.array(
        [(i, (i + 1) % 20, 20) for i in range(20)] + [((i + 1) % 20, i, 21) for i in range(20)]
    )


def walled_box() -> Shape:
    """Return a box 1 x 1 x 2 with a wall across its middle: the wall's edges join three faces."""
    points = np.array([(x, y, z) for z in (0.0, 1.0, 2.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    squares = [(0, 3, 2, 1), (4, 5, 6, 7), (8, 9, 10, 11)]
    for low in (0, 4):
        squares += [(low + i, low + (i + 1) % 4, low + 4 + (i + 1) % 4, low + 4 + i) for i in range(4)]
    faces = [f for a, b, c, d in squares for f in ((a, b, c), (a, c, d))]
    return points, np.array(faces)


def real(name: str) -> Shape:
    """Return one of REAL; the test that asks for it is skipped where it is not there."""
    import trimesh

    if not (BESIDE / name).exists():
        pytest.skip(f"{name} is not beside the repository")
    raw = trimesh.load(BESIDE / name, process=False, force="mesh")
    return np.asarray(raw.vertices, float), np.asarray(raw.faces)


def signed_volume(points: Floats, faces: Ints) -> float:
    """Return the volume inside triangles, one tetrahedron after the other in plain arithmetic."""
    total = 0.0
    for i, j, k in faces.tolist():
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[i], points[j], points[k]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6


def after(session: Session, seconds: float) -> npt.NDArray[np.float32]:
    """Step a session and return where it is then."""
    session.step(seconds)
    return session.positions()
