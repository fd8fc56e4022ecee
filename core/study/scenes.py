"""Scenes, each a function of resolution. Source: PHYSICS.md, section 4."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..base import Floats, Ints
from ..material import PRESETS, Material
from ..mesh import Mesh, base_vertices, mesh_from_triangles
from ..model import Model, build_model
from ..session import Finger, Frame, Session

BALL_RADIUS = 0.08  # [m]
BALL = Material(K1=610, K2=7230, x0=0.0163, k=600, mass=0.2, fill="liquid")
FINGERTIP = 0.020  # [m] radius of the scenes' fingertip
POKE = ((0.25, 1.0), (0.5, 1.0), (0.75, 0.0), (1.0, 0.0))  # (time [s], share of the depth): down, hold, up, free


def ball(subdivisions: int, radius: float = BALL_RADIUS) -> Mesh:
    """Return an icosphere of 10 * 4**subdivisions + 2 vertices."""
    import trimesh

    sphere = trimesh.creation.icosphere(subdivisions, radius)
    return mesh_from_triangles(sphere.vertices, sphere.faces)


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


def free_ball(subdivisions: int) -> Session:
    """Return a ball in the air, twisted about z and stretched: nothing holds it."""
    session = Session(build_model(ball(subdivisions), [BALL]))
    x = session.model.mesh.rest_positions
    angle = 2.0 * x[:, 2] / BALL_RADIUS * 0.3
    twisted = np.stack(
        [x[:, 0] * np.cos(angle) - x[:, 1] * np.sin(angle), x[:, 0] * np.sin(angle) + x[:, 1] * np.cos(angle), x[:, 2]]
    )
    session.place(twisted * np.array([[1.1], [1.0], [0.95]]))
    return session


def poke_ball(subdivisions: int) -> Session:
    """Return a liquid ball of 8 cm and 0.2 kg on its base, a 20 mm fingertip above it."""
    return _under_a_fingertip(ball(subdivisions), BALL)


def poke_cube(cells: int, *, law_set: str = "consistent") -> Session:
    """Return Object 3, the cube of vinyl and water, on its base, a 20 mm fingertip above it."""
    preset = PRESETS[2]
    return _under_a_fingertip(cube(cells, preset.size), preset.material, law_set=law_set)


def stiff_nylon(cells: int) -> Session:
    """Return Object 1, the cube of nylon and air, on its base, a 20 mm fingertip above it."""
    return _under_a_fingertip(cube(cells, PRESETS[0].size), PRESETS[0].material)


def poke(session: Session, *, depth: float = 0.020, frame_rate: float = 60.0, seconds: float = 1.0) -> Iterator[Frame]:
    """Press a body's top straight down, hold, lift and let be; yield each frame.

    Args:
        depth: how far the fingertip goes [m].
        frame_rate: frames a second.
        seconds: of the second the press takes, how many to run.
    """
    x = session.model.mesh.rest_positions
    top = x[:, 2].max() + FINGERTIP
    times, shares = zip((0.0, 0.0), *POKE, strict=True)
    session.set_fingers([Finger((0.0, 0.0, top), FINGERTIP)])
    for i in range(1, round(seconds * frame_rate) + 1):
        down = float(np.interp(i / frame_rate, times, shares)) * depth
        session.set_fingers([Finger((0.0, 0.0, top - down), FINGERTIP)])
        yield session.step(1 / frame_rate)


def _under_a_fingertip(mesh: Mesh, material: Material, *, law_set: str = "consistent") -> Session:
    model: Model = build_model(mesh, [material], law_set=law_set, held=base_vertices(mesh))
    return Session(model)
