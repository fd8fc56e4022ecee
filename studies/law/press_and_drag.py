"""`dev.py core law`: press a mesh at random places and drag over it; the force on the fingertip over the measured law.

A mesh is set up as Blender would: its longest side 165 mm, its base pinned, at the planner's choice, of vinyl that
holds air or water. A place is one that the tip can reach: a sphere that touches there meets nothing else.
"""

from __future__ import annotations

import argparse
import itertools
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from core.base import TICK, DimpleError, Floats, Ints
from core.body.model import Model, build_model
from core.material import Material, law_force
from core.mesh.ray import ray_hit
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.native.motion import Touch
from core.reduction.proxy_rule import plan
from core.session import Finger, Session
from studies.files import write_json
from studies.meshes.mesh_file import SUFFIXES, load_triangles
from studies.meshes.primitives import makers
from studies.meshes.simple import SIZE, Shape
from studies.paper_objects import PRESETS
from studies.scenes import BUDGET

Row = dict[str, Any]
MATERIALS = {"air": PRESETS[1].material, "water": PRESETS[2].material}
SHARES = (0.15, 0.3, 0.6, 1.0, 1.4, 2.0, 3.0)  # of x0: the depths of a press
THICKNESS = 0.6  # of the body there: as deep as is pressed
FRAME, PRESS, SETTLE = 1 / 60, 0.25, 4  # [s], to go in as the Poke tool does [s], and frames of rest at each depth
REACH = 1e-6  # [m] by which a sphere may overlap what it touches
DRAWN = 100  # candidates for each place
SPEEDS = (0.001, 0.010, 0.033, 0.100)  # [m/s] of drags
DEEP, FAR, LONG, PACE = 0.006, 0.040, 2.0, 2.5e-4  # [m] deep, [m] or [s] that a drag goes, [m] between its corners


@dataclass(frozen=True, slots=True)
class Place:
    """Where a body is pressed: point (3,) [m], unit normal (3,) of its face, and how thick the body is there [m]."""

    at: Floats
    outward: Floats
    thickness: float


class Surface:
    """The triangles of a mesh at rest, asked for what is near a point.

    corners: (t, 3, 3) triangle, corner, coordinate [m].
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh, self.corners = mesh, mesh.rest_positions[mesh.triangles]
        self._middles = self.corners.mean(axis=1)
        self._extents = np.linalg.norm(self.corners - self._middles[:, None], axis=2).max(axis=1)

    def nearest(self, point: Floats, within: float) -> Floats:
        """Return the point (3,) [m] of the surface that is nearest, or that of a triangle farther than within [m]."""
        away = np.linalg.norm(self._middles - point, axis=1) - self._extents
        found = closest(self.corners[away <= max(within, away.min() + 1e-12)], point)
        return np.asarray(found[((found - point) ** 2).sum(axis=1).argmin()])

    def thickness(self, at: Floats, inward: Floats) -> float:
        """Return how far it is through the body [m]; its size where a sheet has no other side."""
        start, way = (tuple(map(float, each)) for each in (at + REACH * inward, inward))
        hit = ray_hit(start, way, self.mesh.rest_positions, self.mesh.triangles)  # type: ignore[arg-type]
        return hit[0] if hit else self.mesh.size


def closest(corners: Floats, point: Floats) -> Floats:
    """Return the point (k, 3) of each triangle (k, 3, 3) that is nearest to a point (3,)."""
    from trimesh.triangles import closest_point

    return np.asarray(closest_point(corners, np.broadcast_to(point, (len(corners), 3))))


def places(model: Model, tip: float, count: int, rng: np.random.Generator) -> Iterator[Place]:
    """Yield random places, evenly over the free surface, that a tip [m] can reach, a tip's radius clear of pins."""
    mesh, surface, left = model.mesh, Surface(model.mesh), count
    pinned = mesh.rest_positions[mesh.springs[model.pinned[mesh.springs].all(axis=1)]]
    a, b, c = surface.corners.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
    share = np.where(model.pinned[mesh.triangles].all(axis=1), 0.0, mesh.triangle_areas)
    if not share.any():
        return
    drawn = rng.choice(len(share), DRAWN * count, p=share / share.sum())
    inside = np.einsum("kc,kcx->kx", rng.dirichlet((1.0, 1.0, 1.0), len(drawn)), surface.corners[drawn])
    for triangle, at in zip(drawn, inside, strict=True):
        outward, middle = normals[triangle], at + tip * normals[triangle]
        held = len(pinned) and away_from(pinned, at) < tip
        if not held and np.linalg.norm(surface.nearest(middle, tip) - middle) >= tip - REACH:
            yield Place(at, outward, surface.thickness(at, -outward))
            left -= 1
            if not left:
                return


def away_from(edges: Floats, point: Floats) -> float:
    """Return how far a point (3,) is from the nearest of some edges (k, 2, 3) [m]."""
    start, way = edges[:, 0], edges[:, 1] - edges[:, 0]
    share = ((point - start) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-30)
    return float(np.linalg.norm(start + share.clip(0, 1)[:, None] * way - point, axis=1).min())


def put(session: Session, centre: Floats, tip: float, seconds: float) -> Touch:
    """Move a fingertip to a place (3,) [m] within a time [s]; return how it meets the body then."""
    x, y, z = centre.tolist()
    session.set_fingers([Finger((x, y, z), tip)])
    touch = session.step(seconds).touches[0]
    assert touch
    return touch


def press(session: Session, place: Place, tip: float, depths: Sequence[float]) -> Iterator[Touch]:
    """Press a body at rest as the Poke tool does; yield how the fingertip meets it settled at each depth [m]."""
    session.reset()
    before, step = 0.0, depths[-1] * FRAME / PRESS
    touch = put(session, place.at + tip * place.outward, tip, FRAME)
    for depth in depths:
        on_way = np.linspace(before, depth, max(1, math.ceil((depth - before) / step - 1e-9)) + 1)[1:]
        for each in (*on_way, *[depth] * SETTLE):
            touch = put(session, place.at + (tip - each) * place.outward, tip, FRAME)
        yield touch
        before = depth


def over_surface(surface: Surface, place: Place, tip: float, way: Floats) -> Floats:
    """Return corners (k, 3) [m] of a path that leads a tip over a surface, everywhere DEEP inside it."""
    clear, outward, path = tip - DEEP, place.outward, [place.at + (tip - DEEP) * place.outward]
    for _ in range(round(FAR / PACE)):
        ahead = path[-1] + PACE * way
        below = surface.nearest(ahead, tip)
        outward = (ahead - below) / max(float(np.linalg.norm(ahead - below)), 1e-30)
        path.append(below + clear * outward)
        way = way - (way @ outward) * outward
        way = way / np.linalg.norm(way)
    return np.array(path)


def drag(session: Session, place: Place, tip: float, path: Floats, speed: float) -> list[Touch]:
    """Press a body at rest to the begin of a path (k, 3) [m], drag along it, and return every tick of that."""
    for _ in press(session, place, tip, [DEEP]):
        pass
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    ways = np.arange(TICK * speed, min(along[-1], LONG * speed), TICK * speed)
    corners = np.stack([np.interp(ways, along, each) for each in path.T], axis=1)
    return [put(session, centre, tip, TICK) for centre in corners]


def normal_force(touch: Touch) -> float:
    """Return the force on a fingertip along the normal of the surface [N]."""
    return float(np.dot(touch.force, touch.outward))


def drag_figures(touches: Sequence[Touch], material: Material) -> tuple[Floats, Floats, Floats]:
    """Return the force over the law at its depth, sideways over friction times that, and the jump in each tick.

    Both ratios (t,) where the fingertip is a tenth of DEEP inside. A jump is over the larger force of its two ticks, or
    over that of a rest at DEEP where both are smaller.
    """
    inside = [touch for touch in touches if touch.depth > 0.1 * DEEP]
    law = np.array([material.law(touch.depth) for touch in inside])
    normal = np.array([normal_force(touch) for touch in inside])
    force = np.array([touch.force for touch in touches])
    size = np.maximum(np.linalg.norm(force, axis=1), material.law(DEEP))
    jumps = np.linalg.norm(np.diff(force, axis=0), axis=1) / np.maximum(size[1:], size[:-1])
    total = np.array([np.linalg.norm(touch.force) for touch in inside])
    sideways = np.sqrt(np.maximum(total**2 - normal**2, 0.0))
    return normal / law, sideways / (material.friction * law), jumps


def expected(material: Material, tip: float, depth: float, touch: Touch) -> float:
    """Return the force [N] of a tip [m] at a depth [m]: the law, for another tip than the measuring one predicted."""
    return material.law(depth) if tip == material.indenter.radius else law_force(depth, *touch.law)


def ready(points: Floats, faces: Ints, material: Material) -> tuple[Session, float]:
    """Return a session that is ready for its first frame, as Blender would start it, and the wall time for it [s]."""
    began = time.perf_counter()
    mesh = mesh_from_triangles(points * (SIZE / np.ptp(points[np.unique(faces)], axis=0).max()), faces)
    model = build_model(mesh, [material], pinned=base_vertices(mesh))
    chosen = plan(model, radius=material.indenter.radius, budget=BUDGET)
    session = Session(model, proxy=chosen.proxy)
    return session, time.perf_counter() - began


def press_rows(session: Session, name: str, tip: float, count: int, seed: int) -> Iterator[Row]:
    """Press a body by a tip [m] at random places; yield the force over what is expected at each depth."""
    material = session.model.materials[0]
    found: dict[float, list[float]] = {share: [] for share in SHARES}
    for place in places(session.model, tip, count, np.random.default_rng(seed)):
        shares = [share for share in SHARES if share * material.x0 <= THICKNESS * place.thickness]
        touches = press(session, place, tip, [share * material.x0 for share in shares]) if shares else ()
        for share, touch in zip(shares, touches, strict=True):
            wanted = expected(material, tip, share * material.x0, touch)
            found[share].append(normal_force(touch) / wanted)
    for share, some in found.items():
        yield {"material": name, "tip_mm": 1e3 * tip, "depth_share": share, **spread_of(some)}


def drag_rows(session: Session, name: str, count: int, seed: int) -> Iterator[Row]:
    """Drag over a body from random places in random directions; yield figures by manner and speed."""
    material, rng = session.model.materials[0], np.random.default_rng(seed)
    tip, surface = material.indenter.radius, Surface(session.model.mesh)
    starts = [each for each in places(session.model, tip, count, rng) if DEEP <= THICKNESS * each.thickness]
    paths: dict[str, list[Floats]] = {"over the surface": [], "straight": []}
    for place in starts:
        way: Floats = np.asarray(np.cross(place.outward, rng.normal(size=3)), np.float64)
        way /= np.linalg.norm(way)
        begin = place.at + (tip - DEEP) * place.outward
        paths["over the surface"].append(over_surface(surface, place, tip, way))
        paths["straight"].append(np.stack([begin, begin + FAR * way]))
    for manner, speed in itertools.product(paths, SPEEDS):
        drags = [
            drag_figures(drag(session, place, tip, path, speed), material)
            for place, path in zip(starts, paths[manner], strict=True)
        ]
        over, sideways, jumps = zip(*drags, strict=True) if drags else ((), (), ())
        yield {
            "material": name, "manner": manner, "speed_mm_s": 1e3 * speed,
            "force_over_law": spread_of(np.concatenate([*over, []])),
            "sideways_over_limit": spread_of(np.concatenate([*sideways, []])),
            "jump": spread_of([float(each.max(initial=0.0)) for each in jumps]),
        }  # fmt: skip


def spread_of(values: Floats | Sequence[float]) -> Row:
    """Return how many values there are, their median, 5 and 95 % and their largest, None where there are none."""
    some = np.asarray(values, np.float64)
    found = [round(float(each), 4) for each in np.quantile(some, (0.5, 0.05, 0.95, 1.0))] if len(some) else [None] * 4
    return {"count": len(some), **dict(zip(("median", "p5", "p95", "largest"), found, strict=True))}


def add_law(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_law)
    command.add_argument("--mesh", required=True, metavar="FILE", help="a mesh file, or a built-in: uv-sphere-32-x-16")
    command.add_argument("--places", type=int, default=25, help="number for each tip (default: 25)")
    command.add_argument("--seed", type=int, default=0, help="of the random places")
    command.add_argument("--tips", default="5,10,20", metavar="MM,...", help="radii (default: 5,10,20)")
    command.add_argument("--drag", type=int, nargs="?", const=6, default=0, metavar="N", help="also drag from N places")
    command.add_argument("--json", type=Path, metavar="OUT", help="write all figures")


def run_law(options: argparse.Namespace) -> int:
    """Press, and drag where that is asked for; print the figures."""
    points, faces = triangles_of(options.mesh)
    tips = [1e-3 * float(tip) for tip in options.tips.split(",")]
    found: dict[str, Any] = {"mesh": options.mesh, "ready_s": 0.0, "substeps": 0, "rows": [], "drags": []}
    for name, material in MATERIALS.items():
        session, seconds = ready(points, faces, material)
        found |= {
            "vertices": len(session.model.mass), "measured_tip_mm": 1e3 * material.indenter.radius,
            "ready_s": max(found["ready_s"], round(seconds, 3)), "substeps": max(found["substeps"], session.substeps),
        }  # fmt: skip
        steps = f"{len(session.body.model.mass)} move, {session.substeps} steps a tick"
        print(f"{options.mesh}, {name}: {found['vertices']} vertices, {steps}, ready in {seconds:.2f} s")
        print("  tip, depth / x0: " + "".join(f"{share:^18g}" for share in SHARES))
        for tip in tips:
            rows = list(press_rows(session, name, tip, options.places, options.seed))
            print(f"  {1e3 * tip:5g} mm         " + "".join(f"{words(row):^18}" for row in rows), flush=True)
            found["rows"] += rows
        for row in drag_rows(session, name, options.drag, options.seed) if options.drag else ():
            figures = ", ".join(f"{key} {words(row[key])}" for key in ("force_over_law", "sideways_over_limit"))
            largest = f"largest jump {row['jump']['largest']}"
            print(f"  {row['manner']}, {row['speed_mm_s']:g} mm/s: {figures}, {largest}", flush=True)
            found["drags"].append(row)
    if options.json:
        write_json(options.json, found)
    return 0


def words(row: Row) -> str:
    """Return a spread in words."""
    if not row["count"]:
        return "-"
    return f"{row['median']:.2f} ({row['p5']:.2f}-{row['p95']:.2f})"


def triangles_of(name: str) -> Shape:
    """Return the triangles of a file, or of a made-up mesh by its name.

    Raises:
        DimpleError: there is neither.
    """
    made = {each.lower().replace(" ", "-"): make for each, make in makers().items()}
    if Path(name).suffix.lower() in SUFFIXES:
        return load_triangles(name)
    if name not in made:
        raise DimpleError(f"{name} is no file of {', '.join(SUFFIXES)}, and none of {', '.join(made)}.")
    mesh = made[name]()
    return mesh.rest_positions, mesh.triangles
