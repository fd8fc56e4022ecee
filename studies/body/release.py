"""`dev.py core release`: press some hundred meshes, let go, and see what comes back a second later."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from core.base import Bools, DimpleError, Floats
from core.body.model import Model, build_model
from core.body.shape_matching import fit_pose
from core.material import Material
from core.mesh.ray import ray_hit
from core.mesh.surface import Mesh, base_vertices
from core.reduction.cells import vertex_normals
from core.session import Finger, Session
from studies.files import write_json
from studies.meshes.bodies import DOUGH, FOAM, GEL, NYLON, VINYL, WATER
from studies.meshes.primitives import makers
from studies.reference.laws import rigid_velocity

MATERIALS = {"nylon": NYLON, "vinyl": VINYL, "water": WATER, "gel": GEL, "dough": DOUGH, "foam": FOAM}
TIPS = (0.008, 0.015, 0.025)  # [m] radii of the fingertips
SEED = 3  # of the places that are pressed
FEW = 200  # vertices: liquids on fewer are summed up apart
SHARE = 0.3  # of the smallest side: how deep they go
PINCHED = 0.35  # of the thickness: how deep at most each of two fingertips goes
SHEET = 1e-3  # of the size: what is no thicker is a sheet,
SHEET_SHARE = 0.1  # and pressed by this share of its size
DOWN, HOLD, DRAG, AFTER, SETTLED = 0.25, 0.2, 0.3, 1.0, 0.3  # [s]
BACK = 1e-3  # of the size: what is no further from its place has come back
SLIVER = 1e-6  # of the largest product of areas: what is smaller has no normal in single precision
UPRIGHT = 0.1  # cosine: a face that agrees less with its corners at rest may turn at a touch


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where a mesh is pressed.

    point: (3,) on the surface [m].
    outward: (3,) unit normal there.
    aside: (3,) unit vector across it.
    behind: (3,) point of the far side that a second fingertip presses, None where there is none.
    """

    point: Floats
    outward: Floats
    aside: Floats
    behind: Floats | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Release:
    """What came back of one press.

    mesh, material, way: their names.
    vertices: of the mesh.
    radius: of the fingertip [m].
    depth: how far it went in [m]; less where two would meet.
    force: on it at the end of the hold [N].
    volume_change: then, as a share; 0 of a sheet.
    residual: farthest distance from rest a second after release, over the size; of a free body from its best rigid fit,
        when its spin, which stretches it, had been stopped for SETTLED.
    kinetic: its energy then [J].
    flipped: faces that then looked the other way than at rest.
    finite: whether it never blew up.
    note: of the session, where it did.
    """

    mesh: str
    material: str
    way: str
    vertices: int
    radius: float
    depth: float
    force: float
    volume_change: float
    residual: float
    kinetic: float
    flipped: int
    finite: bool
    note: str

    @property
    def back(self) -> bool:
        """Tell whether it has come back to rest."""
        return self.finite and self.residual <= BACK


Way = Callable[[Place, float, float], list[tuple[float, list[Finger]]]]


def straight(place: Place, radius: float, depth: float) -> list[tuple[float, list[Finger]]]:
    """Return times [s] and fingertips of a press straight in."""
    return [(DOWN, [_tip(place.point, place.outward, radius, depth)])]


def sideways(place: Place, radius: float, depth: float) -> list[tuple[float, list[Finger]]]:
    """Return a press that then slides two radii along the surface."""
    end = place.point + 2 * radius * place.aside
    return [*straight(place, radius, depth), (DRAG, [_tip(end, place.outward, radius, depth)])]


def pinched(place: Place, radius: float, depth: float) -> list[tuple[float, list[Finger]]]:
    """Return a press from both sides at once, not so deep that the fingertips meet; straight in without a far side."""
    if place.behind is not None:
        depth = min(depth, PINCHED * float(np.linalg.norm(place.point - place.behind)))
    first = _tip(place.point, place.outward, radius, depth)
    if place.behind is None:
        return [(DOWN, [first])]
    return [(DOWN, [first, _tip(place.behind, -place.outward, radius, depth)])]


def _tip(point: Floats, outward: Floats, radius: float, depth: float) -> Finger:
    x, y, z = (point + (radius - depth) * outward).tolist()
    return Finger((x, y, z), radius)


# how a mesh is pressed: what the fingertips do, and whether pins hold the base
WAYS: dict[str, tuple[Way, bool]] = {
    "press": (straight, True),
    "drag": (sideways, True),
    "pinch": (pinched, True),
    "free": (straight, False),
}


def smallest_side(mesh: Mesh) -> float:
    """Return the smallest side of the bounding box [m], as much as SHARE says for a sheet."""
    side = float(np.ptp(mesh.rest_positions[~mesh.loose], axis=0).min())
    return side if side > SHEET * mesh.size else SHEET_SHARE / SHARE * mesh.size


def place_at(mesh: Mesh, vertex: int) -> Place:
    """Return the place of a vertex."""
    point = mesh.rest_positions[vertex]
    outward = vertex_normals(mesh.triangles, mesh.rest_positions)[vertex]
    aside = np.cross(outward, np.eye(3)[np.abs(outward).argmin()])
    start = point - 1e-6 * mesh.size * outward
    hit = ray_hit(tuple(start.tolist()), tuple((-outward).tolist()), mesh.rest_positions, mesh.triangles)
    behind = None if hit is None or not mesh.pressurable else np.array(hit[1])
    return Place(point=point, outward=outward, aside=aside / np.linalg.norm(aside), behind=behind)


def release(model: Model, place: Place, way: str, radius: float, **names: str) -> Release:
    """Press a body, let go and measure it a second later.

    Args:
        way: one of WAYS.
        names: of mesh and material.
    """
    mesh, session = model.mesh, Session(model)
    depth = SHARE * smallest_side(mesh)
    keys = WAYS[way][0](place, radius, depth)
    first = keys[0][1]
    out = [place.outward, -place.outward]
    session.set_fingers([_clear(finger, way, depth) for finger, way in zip(first, out, strict=False)])
    frames = [session.step(0.01)]
    for seconds, fingers in keys:
        session.set_fingers(fingers)
        frames.append(session.step(seconds))
    frames.append(held := session.step(HOLD))
    session.set_fingers([])
    frames += [session.step(AFTER / 10) for _ in range(10)]
    if model.free:
        x, v = session.body.positions(), session.body.velocities()
        session.body.set_state(x, v - rigid_velocity(model.mass, x, v))
        frames.append(session.step(SETTLED))
    x, v = session.body.positions(), session.body.velocities()
    notes = [frame.note for frame in frames if frame.note]
    return Release(
        way=way, mesh=names["mesh"], material=names["material"], vertices=len(mesh.rest_positions), radius=radius,
        depth=depth, force=float(np.linalg.norm(held.finger_forces[:1])),
        volume_change=held.volume / mesh.volume - 1 if mesh.pressurable else 0.0,
        residual=residual(model, x), kinetic=float((model.mass * v**2).sum()) / 2, flipped=flipped(mesh, x),
        finite=not notes and bool(np.isfinite(x).all()), note=notes[0] if notes else "",
    )  # fmt: skip


def _clear(finger: Finger, outward: Floats, depth: float) -> Finger:
    x, y, z = (np.array(finger.position) + depth * outward).tolist()
    return Finger((x, y, z), finger.radius)


def residual(model: Model, x: Floats) -> float:
    """Return the farthest distance of positions (3, n) from rest over the size, without a free body's rigid motion."""
    used, rest = ~model.mesh.loose, model.matching.rest
    rotation, translation = (np.eye(3), np.zeros(3))
    if model.free:
        rotation, translation = fit_pose(rest[:, used], x[:, used], model.mass[used])
    away = x - rotation @ rest - translation[:, None]
    return float(np.sqrt((away[:, used] ** 2).sum(axis=0)).max()) / model.mesh.size


def flipped(mesh: Mesh, x: Floats) -> int:
    """Return how many faces look the other way than at rest, seen from the surface round them."""
    now, rest = _agreement(mesh, x.T), _agreement(mesh, mesh.rest_positions)
    return int(np.count_nonzero((now < 0) & (rest > UPRIGHT)))


def _agreement(mesh: Mesh, x: Floats) -> Floats:
    """Return the cosine (t,) between the normal of each face and the mean one of its corners; slivers have 0."""
    a, b, c = x[mesh.triangles].transpose(1, 0, 2)
    face, around = np.cross(b - a, c - a), vertex_normals(mesh.triangles, x)[mesh.triangles].sum(axis=1)
    length = np.linalg.norm(face, axis=1) * np.linalg.norm(around, axis=1)
    agreement: Floats = (face * around).sum(axis=1) / np.maximum(length, SLIVER * length.max())
    return agreement


def run_mesh(
    name: str, mesh: Mesh, materials: Sequence[tuple[str, Material]], ways: Sequence[str]
) -> Iterator[Release]:
    """Yield what comes back of presses on one mesh, a material for each fingertip; none where nothing is free.

    Raises:
        DimpleError: it cannot be simulated.
    """
    rng = np.random.default_rng(SEED)
    for way in ways:
        for radius, (label, material) in zip(TIPS, materials, strict=True):
            pinned: Bools | None = base_vertices(mesh) if WAYS[way][1] else None
            model = build_model(mesh, [material], pinned=pinned)
            if model.free:  # a body pinned at one vertex swings on
                model = build_model(mesh, [material])
            free = np.flatnonzero(~model.pinned)
            if len(free):
                place = place_at(mesh, int(rng.choice(free)))
                yield release(model, place, way, radius, mesh=name, material=label)


def add_release(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_release)
    command.add_argument("--json", type=Path, metavar="FILE", help="write each press and the totals")
    command.add_argument("--only", default="", metavar="WORD", help="only meshes whose name contains it")


def run_release(options: argparse.Namespace) -> int:
    """Press, print what did not come back, and sum up; the exit code is 1 where something did not."""
    materials = list(MATERIALS.items())
    found: list[Release] = []
    count, refused = 0, {}
    for name, make in makers().items():
        if options.only not in name:
            continue
        mesh = make()
        some = [materials[(3 * count + i) % len(materials)] for i in range(len(TIPS))]
        if count % 4 >= 2:  # other radii for them
            some = some[1:] + some[:1]
        count += 1
        try:
            for one in run_mesh(name, mesh, some, ["press"]):
                found.append(one)
                if not one.back or one.flipped:
                    print(line(one), flush=True)
        except DimpleError as error:
            refused[name] = str(error)
            print(f"{name}: {error}")
    total = summary(found, count, refused)
    print(json.dumps(total, indent=1))
    if options.json:
        write_json(options.json, {**total, "rows": [asdict(one) for one in found]})
    return int(not all(one.back for one in found))


def line(one: Release) -> str:
    """Return one press in words."""
    words = [
        f"{one.mesh} ({one.vertices}), {one.material}, {one.way}",
        f"tip {1e3 * one.radius:g} mm, {1e3 * one.depth:.1f} mm deep, {one.force:.1f} N",
        f"residual {one.residual:.1e} of the size",
        f"{one.kinetic:.1e} J",
        f"volume {100 * one.volume_change:+.2f} %",
        f"{one.flipped} faces flipped",
        one.note,
    ]
    return ", ".join(word for word in words if word)


def summary(found: Sequence[Release], count: int, refused: dict[str, str]) -> dict[str, object]:
    """Return the sums over all presses."""
    worst = max(found, key=lambda one: one.residual, default=None)
    liquids = [one for one in found if MATERIALS[one.material].fill == "liquid"]
    volumes = [max((abs(one.volume_change) for one in some), default=0.0) for some in (
        [one for one in liquids if one.vertices < FEW], [one for one in liquids if one.vertices >= FEW])]  # fmt: skip
    return {
        "meshes": count, "meshes_pressed": len({one.mesh for one in found}), "presses": len(found),
        "not_back": sum(not one.back for one in found), "flipped": sum(one.flipped > 0 for one in found),
        "refused": refused,
        "worst": line(worst) if worst else "",
        "liquid_volume_change_below_200_vertices": volumes[0], "liquid_volume_change_from_200_vertices": volumes[1],
    }  # fmt: skip
