"""Bodies that test proxies: shapes x materials x fingertips x pins."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from core.base import Bools, Floats
from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from studies.paper_objects import PRESETS
from studies.scenes import BALL, cube

NYLON, VINYL, WATER = (preset.material for preset in PRESETS)
GEL = Material(K1=200, K2=900, x0=0.010, k=300, density=1000, damping_ratio=0.4, fill="liquid")
DOUGH = Material(K1=600, K2=700, x0=0.012, k=600, density=700, damping_ratio=0.6, fill="air")
FOAM = Material(K1=1500, K2=4000, x0=0.008, k=2000, mass=0.15, damping_ratio=0.3, fill="none")
FINE = 26  # squares along a side of a cube: 4058 vertices, and about as many on the other shapes
SHARE = 0.1  # of the length: what is pinned at an end


class BodyCase(NamedTuple):
    """A body and the fingertip that presses it.

    shape: function of fineness and size that makes the mesh.
    size: largest dimension [m].
    material: of the whole body.
    radius: of the fingertip [m].
    pins: "base", "ends" (both ends along x), "side" (the low end along y) or "belt" (round the middle along x).
    """

    shape: Callable[[int, float], Mesh]
    size: float
    material: Material
    radius: float
    pins: str = "base"

    @property
    def name(self) -> str:
        """Return the name in tables: shape, material and pins."""
        return f"{self.shape.__name__} {_NAMES.get(self.material, self.material.fill)} {self.pins}"


def build(body: BodyCase, fine: int = FINE) -> Model:
    """Return the model of a body."""
    mesh = body.shape(fine, body.size)
    return build_model(mesh, [body.material], pinned=_PINS[body.pins](mesh))


def ball(fine: int, size: float) -> Mesh:
    """Return a cube blown up to a ball, its squares of even angles."""
    return _round(fine, size, lambda way: np.ones(len(way)))


def blob(fine: int, size: float) -> Mesh:
    """Return a ball with smooth hills at random."""
    rng = np.random.default_rng(5)
    waves, phase = 2.5 * rng.normal(size=(12, 3)), rng.uniform(0, 2 * np.pi, 12)
    return _round(fine, size, lambda way: 1 + 0.06 * np.sin(way @ waves.T + phase).sum(axis=1))


def head(fine: int, size: float) -> Mesh:
    """Return a head with two ears, a muzzle and two eye sockets."""
    features = (
        ((0.9, 0.1, 0.4), 0.5, 0.25), ((-0.9, 0.1, 0.4), 0.5, 0.25), ((0, -1, -0.2), 0.5, 0.4),
        ((0.35, -0.8, 0.35), -0.15, 0.18), ((-0.35, -0.8, 0.35), -0.15, 0.18),
    )  # fmt: skip

    def reach(way: Floats) -> Floats:
        out = np.ones(len(way))
        for place, height, width in features:
            middle = np.array(place) / np.linalg.norm(place)
            out += height * np.exp(-((way - middle) ** 2).sum(axis=1) / width**2)
        return out

    return _round(fine, size, reach)


def scan(fine: int, size: float) -> Mesh:
    """Return a cushion as a scanner sees it: rough, and finer on one part than on another."""
    mesh, rng = ball(fine, 2.0), np.random.default_rng(2)
    way = mesh.rest_positions + 0.5 / fine * rng.normal(size=mesh.rest_positions.shape) / 2
    way /= np.linalg.norm(way, axis=1)[:, None]
    rough = 1 + 0.003 * rng.normal(size=len(way))
    uneven = way * (1 + 0.35 * np.abs(way[:, 0]))[:, None] * np.array([1, 0.8, 0.5]) * rough[:, None]
    return _sized(uneven, mesh, size)


def box(fine: int, size: float) -> Mesh:
    """Return a cube."""
    return cube(fine, size)


def slab(fine: int, size: float) -> Mesh:
    """Return a flat box with squares of three shapes."""
    mesh = cube(fine, size)
    return mesh_from_triangles(mesh.rest_positions * np.array([1, 0.7, 0.35]), mesh.triangles)


def torus(fine: int, size: float) -> Mesh:
    """Return a ring that lies."""
    import trimesh

    round_it = round(1.77 * fine)
    made = trimesh.creation.torus(0.35 * size, 0.15 * size, major_sections=2 * round_it, minor_sections=round_it)
    return mesh_from_triangles(made.vertices, made.faces)


def capsule(fine: int, size: float) -> Mesh:
    """Return a lying capsule three times as long as thick."""
    import trimesh

    turn = np.linspace(0, np.pi / 2, round(0.7 * fine))
    end, tube = np.stack([np.sin(turn), -np.cos(turn)], axis=1), np.linspace(0, 4, round(1.7 * fine))[1:-1]
    side = np.stack([np.ones(len(tube)), tube], axis=1)
    outline = np.concatenate([end, side, end[::-1] * [1, -1] + [0, 4]]) * size / 6
    made = trimesh.creation.revolve(outline, sections=round(1.3 * fine))
    return mesh_from_triangles(np.asarray(made.vertices)[:, [2, 0, 1]], made.faces)


def cup(fine: int, size: float) -> Mesh:
    """Return a cup without a lid: an open mesh with a crease."""
    import trimesh

    floor, wall = 0.4 * fine, 1.5 * fine
    across, up = np.linspace(0, 0.3, round(floor)), np.linspace(0, 1, round(wall))[1:]
    outline = [[x, 0.0] for x in across] + [[0.3, z] for z in up]
    made = trimesh.creation.revolve(size * np.array(outline), sections=3 * fine)
    return mesh_from_triangles(made.vertices, made.faces)


def star(fine: int, size: float) -> Mesh:
    """Return a star with five round arms."""
    return _round(fine, size, lambda way: 1 + 0.3 * np.cos(5 * np.arctan2(way[:, 1], way[:, 0])) * (1 - way[:, 2] ** 2))


def cushion(fine: int, size: float) -> Mesh:
    """Return a cube with round edges and corners."""
    return _round(fine, size, lambda way: (way**4).sum(axis=1) ** -0.25)


def banana(fine: int, size: float) -> Mesh:
    """Return a long body that is bent."""
    mesh = ball(fine, 2.0)
    x = mesh.rest_positions * np.array([1, 0.35, 0.3])
    x[:, 2] -= 0.4 * x[:, 0] ** 2
    return _sized(x, mesh, size)


def wedge(fine: int, size: float) -> Mesh:
    """Return a block that runs out to an edge."""
    mesh = cube(fine, size)
    x = mesh.rest_positions.copy()
    x[:, 2] *= 0.6 * (0.55 - x[:, 0] / size)
    return mesh_from_triangles(x, mesh.triangles)


def cone(fine: int, size: float) -> Mesh:
    """Return a cone on its base."""
    across, up = np.linspace(0, 0.4, round(0.8 * fine)), np.linspace(1, 0, round(1.8 * fine))
    return _turned([[x, 0.0] for x in across] + [[0.4 * z, 1 - z] for z in up[1:]], size, round(2.3 * fine))


def dumbbell(fine: int, size: float) -> Mesh:
    """Return two balls and a neck between them, lying."""
    along = -np.cos(np.linspace(0, np.pi, round(2.4 * fine)))
    thick = 0.35 * np.sqrt(1 - along**2) * (1 - 0.5 * np.exp(-((along / 0.3) ** 2)))
    mesh = _turned(np.stack([thick, along], axis=1) / 2, size, round(2.0 * fine))
    return mesh_from_triangles(mesh.rest_positions[:, [2, 0, 1]], mesh.triangles)


def _turned(outline: ArrayLike, size: float, sections: int) -> Mesh:
    """Return what an outline of distances from the axis and heights (n, 2) goes round."""
    import trimesh

    made = trimesh.creation.revolve(size * np.array(outline), sections=sections)
    return mesh_from_triangles(made.vertices, made.faces)


def _round(fine: int, size: float, reach: Callable[[Floats], Floats]) -> Mesh:
    mesh = cube(fine, 2.0)
    way = np.tan(mesh.rest_positions * np.pi / 4)
    way /= np.linalg.norm(way, axis=1)[:, None]
    return _sized(way * reach(way)[:, None], mesh, size)


def _sized(x: Floats, mesh: Mesh, size: float) -> Mesh:
    return mesh_from_triangles(x * (size / np.ptp(x, axis=0).max()), mesh.triangles)


def _at_end(mesh: Mesh, axis: int) -> Floats:
    """Return how far along an axis the input vertices are, from 0 to 1."""
    x = mesh.rest_positions[mesh.source, axis]
    along: Floats = (x - x.min()) / np.ptp(x)
    return along


def _ends(mesh: Mesh) -> Bools:
    return np.abs(_at_end(mesh, 0) - 0.5) > 0.5 - SHARE


def _side(mesh: Mesh) -> Bools:
    return _at_end(mesh, 1) < SHARE


def _belt(mesh: Mesh) -> Bools:
    return np.abs(_at_end(mesh, 0) - 0.5) < SHARE / 2


_PINS: dict[str, Callable[[Mesh], Bools]] = {"base": base_vertices, "ends": _ends, "side": _side, "belt": _belt}
_NAMES = {
    BALL: "light liquid", NYLON: "nylon", VINYL: "vinyl", WATER: "water", GEL: "gel", FOAM: "foam", DOUGH: "dough",
}  # fmt: skip


BODIES = tuple(BodyCase(*row) for row in (
    (ball, 0.16, BALL, 0.020, "base"), (ball, 0.16, VINYL, 0.030, "ends"), (ball, 0.16, WATER, 0.012, "base"),
    (ball, 0.06, NYLON, 0.008, "side"), (box, 0.05, NYLON, 0.010, "base"), (box, 0.05, NYLON, 0.006, "side"),
    (box, 0.165, WATER, 0.020, "base"), (box, 0.165, VINYL, 0.030, "ends"), (torus, 0.17, VINYL, 0.015, "base"),
    (torus, 0.17, BALL, 0.012, "ends"), (torus, 0.17, WATER, 0.018, "side"), (torus, 0.10, NYLON, 0.008, "base"),
    (capsule, 0.19, BALL, 0.015, "base"), (capsule, 0.12, FOAM, 0.008, "ends"), (blob, 0.15, GEL, 0.018, "base"),
    (blob, 0.15, VINYL, 0.025, "side"), (head, 0.20, GEL, 0.016, "base"), (head, 0.20, FOAM, 0.020, "side"),
    (slab, 0.16, WATER, 0.018, "ends"), (slab, 0.16, GEL, 0.022, "base"), (cup, 0.12, FOAM, 0.010, "base"),
    (cup, 0.12, NYLON, 0.014, "base"), (scan, 0.18, WATER, 0.015, "base"), (scan, 0.18, VINYL, 0.022, "ends"),
    (star, 0.18, DOUGH, 0.014, "base"), (cone, 0.15, GEL, 0.016, "base"), (dumbbell, 0.20, WATER, 0.013, "belt"),
    (wedge, 0.14, FOAM, 0.012, "side"), (cushion, 0.16, VINYL, 0.020, "belt"), (banana, 0.20, DOUGH, 0.012, "ends"),
))  # fmt: skip
