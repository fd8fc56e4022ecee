"""Bodies the planner is judged on: shapes x materials x fingertips x pins, those the fit used and those it never saw.

The rule of the split: the fit uses balls, cubes and tori of the paper's materials and of `scenes.BALL`. Every other
shape is unseen, and half of those are of materials that are unseen too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import Bools, Floats
from ..material import PRESETS, Material
from ..mesh import Mesh, base_vertices, mesh_from_triangles
from ..model import Model, build_model
from .scenes import BALL, cube

NYLON, VINYL, WATER = (preset.material for preset in PRESETS)
GEL = Material(K1=200, K2=900, x0=0.010, k=300, density=1000, damping_ratio=0.4, fill="liquid")
FOAM = Material(K1=1500, K2=4000, x0=0.008, k=2000, mass=0.15, damping_ratio=0.3, fill="none")
FINE = 26  # squares along a side of a cube: 4058 vertices, and about as many on the other shapes
SHARE = 0.1  # of its length: what is held at an end


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """Name a body: its shape (a function of fineness and size), size [m], material, fingertip radius [m], pins.

    pins: "base", "ends" (both ends along x) or "side" (the low end along y).
    """

    shape: Callable[[int, float], Mesh]
    size: float
    material: Material
    radius: float
    pins: str = "base"

    @property
    def name(self) -> str:
        """Return what a table calls it."""
        return f"{self.shape.__name__} {_NAMES[self.material]} {self.pins}"


def build(body: Body, fine: int = FINE) -> Model:
    """Return the model of a body."""
    mesh = body.shape(fine, body.size)
    return build_model(mesh, [body.material], held=_PINS[body.pins](mesh))


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


_PINS: dict[str, Callable[[Mesh], Bools]] = {"base": base_vertices, "ends": _ends, "side": _side}
_NAMES = {BALL: "light liquid", NYLON: "nylon", VINYL: "vinyl", WATER: "water", GEL: "gel", FOAM: "foam"}

FITTED = tuple(
    Body(shape=shape, size=size, material=material, radius=radius, pins=pins)
    for shape, size, material, radius, pins in (
        (ball, 0.16, BALL, 0.020, "base"), (ball, 0.16, VINYL, 0.030, "ends"), (ball, 0.16, WATER, 0.012, "base"),
        (ball, 0.06, NYLON, 0.008, "side"), (box, 0.05, NYLON, 0.010, "base"), (box, 0.05, NYLON, 0.006, "side"),
        (box, 0.165, WATER, 0.020, "base"), (box, 0.165, VINYL, 0.030, "ends"), (torus, 0.17, VINYL, 0.015, "base"),
        (torus, 0.17, BALL, 0.012, "ends"), (torus, 0.17, WATER, 0.018, "side"), (torus, 0.10, NYLON, 0.008, "base"),
    )
)  # fmt: skip
UNSEEN = tuple(
    Body(shape=shape, size=size, material=material, radius=radius, pins=pins)
    for shape, size, material, radius, pins in (
        (capsule, 0.19, BALL, 0.015, "base"), (capsule, 0.12, FOAM, 0.008, "ends"), (blob, 0.15, GEL, 0.018, "base"),
        (blob, 0.15, VINYL, 0.025, "side"), (head, 0.20, GEL, 0.016, "base"), (head, 0.20, FOAM, 0.020, "side"),
        (slab, 0.16, WATER, 0.018, "ends"), (slab, 0.16, GEL, 0.022, "base"), (cup, 0.12, FOAM, 0.010, "base"),
        (cup, 0.12, NYLON, 0.014, "base"), (scan, 0.18, WATER, 0.015, "base"), (scan, 0.18, VINYL, 0.022, "ends"),
    )
)  # fmt: skip
