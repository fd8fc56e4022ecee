"""`dev.py core led`: lead rigid shapes, whole and cut, into soft bodies, and measure whether the skin gives way.

A shape moves 30 mm down along a prescribed path into a body that is pinned below. It should follow the path exactly,
with the skin under it and nothing inside it, and its force should not depend on how its faces are cut.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import trimesh

from core.base import Bools, Floats, Ints
from core.body.model import build_model
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from core.world.props import touching_gap
from studies.contact.judge import winding
from studies.contact.meeting import met
from studies.files import write_json
from studies.meshes.simple import Shape, cube, icosphere
from studies.reference.crossing import find_crossings
from studies.reference.facets import nearest_on_triangles
from studies.reference.proximity import join_surfaces

MATERIAL = Material(K1=600, K2=4000, x0=0.02, k=400, spread=0.02, mass=0.15, friction=0.4)
SIDE, DEEP, ABOVE = 0.1, 0.03, 0.002  # [m] of the cube, how deep shapes are led into it, and from where
MIDDLE = (7e-4, 1.3e-3)  # [m] where they come down: on no edge of the skin
SPEEDS, CUTS = (0.01, 0.1, 1.0), (0, 1, 2, 3)  # [m/s]; subdivisions
HEAD, FRICTION = 0.05, 0.4  # [m] longest side of Suzanne; of the shapes
LOWEST, DOWN = 1e-3, 0.5  # [m] of a shape that press for certain, where they look down: cosine
PLACES = 400  # of its underside, below which the skin is sought
BLOCK = 100_000  # pairs of a point and a face at once


@dataclass(frozen=True, slots=True, kw_only=True)
class Led:
    """What came of leading one shape into a body.

    shape, cuts, speed, body: its name, its subdivisions, its speed [m/s], and the name of the body.
    late: largest distance of a vertex behind its path, at any tick [m].
    gap: from its underside to the skin, in the middle of all its places [m], and
    gap_of_nine: what nine of ten places keep to; surfaces touch at a distance of `touch`.
    inside: vertices of the skin inside it, and
    crossing: pairs of their faces that pass through each other.
    force: on it at rest [N].
    """

    shape: str
    cuts: int
    speed: float
    body: str
    late: float
    gap: float
    gap_of_nine: float
    touch: float
    inside: int
    crossing: int
    force: float


def star() -> trimesh.Trimesh:
    """Return a prism over a star of five points."""
    turn = np.arange(10) * np.pi / 5
    r = np.where(np.arange(10) % 2, 0.012, 0.03)
    rim = [np.c_[r * np.cos(turn), r * np.sin(turn), np.full(10, z)] for z in (0.0, 0.02)]
    faces = []
    for i in range(10):
        j = (i + 1) % 10
        faces += [[20, j, i], [21, 10 + i, 10 + j], [i, j, 10 + j], [i, 10 + j, 10 + i]]
    return trimesh.Trimesh(np.concatenate([*rim, [[0, 0, 0], [0, 0, 0.02]]]), faces)


def cone() -> trimesh.Trimesh:
    """Return a thin cone that stands on its tip."""
    made = trimesh.creation.cone(0.01, 0.06, sections=12)
    made.vertices[:, 2] *= -1
    made.invert()
    return made


def suzanne() -> trimesh.Trimesh:
    """Return Blender's monkey as it is added: a head, two eyes let into it, and holes behind them."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    mesh.calc_loop_triangles()
    points = np.array([v.co for v in mesh.vertices])
    faces = np.array([t.vertices for t in mesh.loop_triangles])
    return trimesh.Trimesh(points * HEAD / np.ptp(points, axis=0).max(), faces, process=False)


SHAPES: dict[str, Callable[[], trimesh.Trimesh]] = {
    "box": lambda: trimesh.creation.box((0.03, 0.03, 0.03)), "bar": lambda: trimesh.creation.box((0.03, 0.2, 0.03)),
    "plate": lambda: trimesh.creation.box((0.06, 0.06, 0.01)), "star": star, "cone": cone,
    "blade": lambda: trimesh.creation.box((0.004, 0.2, 0.04)), "suzanne": suzanne,
}  # fmt: skip


def shape(name: str, cuts: int) -> tuple[Floats, Ints]:
    """Return a shape above the body, each of its triangles cut into four as often as `cuts` says."""
    made = SHAPES[name]()
    for _ in range(cuts):
        made = made.subdivide()
    points = np.array(made.vertices)
    return points - [0, 0, points[:, 2].min()] + [*MIDDLE, ABOVE], np.array(made.faces)


def soft_cube(cells: int = 16) -> Session:
    """Return a cube that is pinned below; its top is at a height of 0."""
    mesh = cube(cells, SIDE)
    return _soft((mesh.rest_positions - [0, 0, SIDE / 2], mesh.triangles), -SIDE + 1e-6)


def soft_ball(height: float = SIDE) -> Session:
    """Return a ball of a height [m], a pillow where that is less than its width, pinned below; its top is at 0."""
    points, faces = icosphere(4, SIDE / 2)
    return _soft((points * [1, 1, height / SIDE] - [0, 0, height / 2], faces), -0.9 * height)


def _soft(made: Shape, low: float) -> Session:
    points, faces = made
    return Session(build_model(mesh_from_triangles(points, faces), [MATERIAL], pinned=points[:, 2] < low))


BODIES: dict[str, Callable[[], Session]] = {
    "cube": soft_cube, "fine cube": lambda: soft_cube(32), "ball": soft_ball, "pillow": lambda: soft_ball(0.6 * SIDE)
}  # fmt: skip


def lead(name: str, cuts: int, speed: float, body: str, friction: float = FRICTION) -> Led:
    """Lead a shape into a body, and measure both at rest."""
    session, (start, faces) = BODIES[body](), shape(name, cuts)
    world = World([session], [Collider(start.T.copy(), faces, friction)])
    ticks, late = round((DEEP + ABOVE) / speed / 1e-3), 0.0
    for tick in range(1, ticks + 1):
        end = start - [0, 0, (DEEP + ABOVE) * tick / ticks]
        world.set_colliders([end])
        world.step(1e-3)
        late = max(late, float(np.abs(world.collider(0) - end).max()))
    for _ in range(20):
        world.step(1e-2)
    force = np.mean([met(world, 1e-3).forces[1, 2] for _ in range(20)])
    whole, whole_faces = shape(name, 0)  # the same surface
    whole = whole - [0, 0, DEEP + ABOVE]
    skin, skin_faces = session.body.positions().T, session.body.model.mesh.triangles
    places = underside(whole, whole_faces)
    near = gaps(places[within(places, session.body.model.mesh.rest_positions, skin_faces)], skin, skin_faces)
    return Led(
        shape=name, cuts=cuts, speed=speed, body=body, late=late, gap=float(np.median(near)),
        gap_of_nine=float(np.quantile(near, 0.9)), touch=touching_gap(session),
        inside=int(within(skin, whole, whole_faces).sum()), force=float(force),
        crossing=crossing((skin, skin_faces), (whole, whole_faces)),
    )  # fmt: skip


def underside(points: Floats, faces: Ints) -> Floats:
    """Return places (p, 3) [m], evenly on what looks down of a shape's lowest millimetre, and its lowest vertex."""
    made, low = trimesh.Trimesh(points, faces, process=False), points[points[:, 2].argmin()]
    lowest = trimesh.Trimesh(points, faces[(made.triangles[:, :, 2] < low[2] + LOWEST).any(axis=1)], process=False)
    places, which = trimesh.sample.sample_surface_even(lowest, PLACES, seed=0)
    pressing = (places[:, 2] < low[2] + LOWEST) & (lowest.face_normals[which, 2] < -DOWN)
    return np.concatenate([low[None], places[pressing]])


def gaps(places: Floats, skin: Floats, faces: Ints) -> Floats:
    """Return the distance (p,) [m] of places (p, 3) from a surface."""
    corners = skin[faces].transpose(2, 0, 1)
    nearest = (np.einsum("ctk,tk->ct", corners, nearest_on_triangles(corners, place)) for place in places)
    found = [np.linalg.norm(near - place[:, None], axis=0).min() for near, place in zip(nearest, places, strict=True)]
    return np.array(found)


def within(places: Floats, points: Floats, faces: Ints) -> Bools:
    """Return which places (p, 3) are inside a surface."""
    found = ((places > points.min(axis=0)) & (places < points.max(axis=0))).all(axis=1)
    near = places[found]
    parts = np.array_split(near, len(near) * len(faces) // BLOCK + 1)
    found[found] = np.concatenate([np.abs(winding(part, points, faces)) > 0.5 for part in parts])
    return found


def crossing(*surfaces: Shape) -> int:
    """Return how many faces of one surface pass through faces of the other, by the reference in numpy."""
    points, faces = zip(*surfaces, strict=True)
    joined = join_surfaces(list(points), list(faces))
    free, kept = np.array([True, False]), np.zeros(len(joined.rest), bool)
    return find_crossings(joined, joined.rest, free, [False], kept).pairs


def add_led(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_led)
    command.add_argument("--shapes", nargs="+", choices=SHAPES, default=list(SHAPES), metavar="SHAPE")
    command.add_argument("--bodies", nargs="+", choices=BODIES, default=["cube", "ball", "pillow"], metavar="BODY")
    command.add_argument("--cuts", nargs="+", type=int, default=[*CUTS], metavar="N")
    command.add_argument("--speeds", nargs="+", type=float, default=SPEEDS, metavar="M/S")
    command.add_argument("--friction", type=float, default=FRICTION, metavar="MU", help="of the shapes")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the results")


def run_led(options: argparse.Namespace) -> int:
    """Lead all shapes into all bodies; return 1 if one is late or something is inside it."""
    rows: list[Led] = []
    print("shape     body         m/s  cuts  late, gap, of nine in ten, touch [mm]  inside  crossing  force [N], ratio")
    for name, body, speed in itertools.product(options.shapes, options.bodies, options.speeds):
        for cuts in options.cuts:
            rows.append(lead(name, cuts, speed, body, options.friction))
            print(_line(rows[-1], rows[-1 - options.cuts.index(cuts)]), flush=True)
    if options.json:
        write_json(options.json, [asdict(row) for row in rows])
    return int(any(row.late > 1e-9 or row.inside or row.crossing for row in rows))


def _line(row: Led, whole: Led) -> str:
    lengths = "  ".join(f"{1e3 * length:5.2f}" for length in (row.late, row.gap, row.gap_of_nine, row.touch))
    met = f"{row.inside:3}  {row.crossing:3}  {row.force:8.1f}  {row.force / whole.force:6.3f}"
    return f"{row.shape:8}  {row.body:9}  {row.speed:5g}  {row.cuts}  {lengths}  {met}"
