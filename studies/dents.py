"""`dev.py core dents`: how smooth settled dents are, and how near to those of finite elements.

A dent is smooth to about two radii of the fingertip. Deeper, the places at rest of the skin below the tip lie above the
tip's centre and pull it back round the tip: at the bottom it is farthest from them. Tension and friction keep it there,
else it slips to some side, and the dent leans: at 2.5 radii by some 3 % of its depth. Under a tip of 20 mm, to which
25 mm are 1.25 radii, it does not, and with a friction of 2 it does not either (`--parts friction`). A proxy whose edges
are longer than the tip's radius is rough at any depth.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.base import DimpleError, Floats
from core.body.estimate import estimate
from core.body.model import Model, build_model
from core.material import DEFAULT_MATERIAL, PRESETS, Material
from core.mesh.surface import Mesh, base_vertices
from core.reduction.proxy import build_proxy, mean_spacing
from core.reduction.proxy_rule import plan
from core.session import Finger, Session

from .dent_picture import draw_dents, draw_profiles
from .dent_shape import Profile, facet_roughness, lean, profile, turned_onto, vertex_roughness
from .primitives import Shape, icosphere, rotated, sized
from .solid_mesh import BALL_RADIUS

MATERIALS = {"default": DEFAULT_MATERIAL, **{preset.name: preset.material for preset in PRESETS}}
TIP = 0.010  # [m] radius of the fingertip whose dents are drawn
DEPTHS = (0.005, 0.010, 0.015, 0.020, 0.025)  # [m]
BALLS = {2562: 4, 10242: 5, 40962: 6, 163842: 7}  # vertices and subdivisions
PROXIED, PROXIES = (10242, 163842), (600, 1500)  # fine meshes, and vertices of proxies beside the one of a session
TIPS = (0.010, 0.020)  # [m] radii of those whose dents are compared
RATE = 500.0  # [1/s] at which a body as light and damped as these settles
TRAVEL = 0.1  # [m/s] of the fingertip
SETTLING = 0.07  # [s] at each depth
FINE = 5  # subdivisions of the ball whose profile is compared
FRICTIONS = (0.5, 1.0, 2.0)  # of the skin under deep dents
PARTS = ("roughness", "friction", "profile", "other-tip")
KEPT = Path(__file__).parents[1] / "tests" / "studies" / "solid"  # dents by finite elements


@dataclass(frozen=True, slots=True)
class Settled:
    """A body at rest under a fingertip.

    depth: of the tip below the surface at rest [m].
    positions: of the vertices of the mesh (n, 3) [m].
    """

    depth: float
    positions: Floats


def light(mesh: Mesh, material: Material) -> Model:
    """Return a body that settles within some ticks: light, critically damped, pinned at its base."""
    mass = estimate(material, mesh.size).kappa1 * float(mesh.triangle_areas.sum()) / RATE**2
    still = replace(material, mass=mass, density=None, damping_ratio=1.0)
    return build_model(mesh, [still], pinned=base_vertices(mesh))


def settle(
    mesh: Mesh, material: Material, radius: float, depths: Sequence[float], *, proxy: int = 0
) -> Iterator[Settled]:
    """Press a body from above onto the middle of its top, to each depth in turn; yield where it rests.

    Args:
        radius: of the fingertip [m].
        proxy: vertices of the proxy that moves in its place, 0: none.
    """
    model = light(mesh, material)
    session = Session(model, proxy=build_proxy(model, proxy) if proxy else None)
    top, at = float(mesh.rest_positions[:, 2].max()), 0.0
    session.set_fingers([Finger((0.0, 0.0, top + radius), radius)])
    for depth in depths:
        session.set_fingers([Finger((0.0, 0.0, top + radius - depth), radius)])
        session.step((depth - at) / TRAVEL)
        session.step(SETTLING)
        at = depth
        yield Settled(depth, session.skin())


def ball(subdivisions: int) -> Mesh:
    """Return the ball of the finite elements, an icosphere."""
    return sized(*icosphere(subdivisions), 2 * BALL_RADIUS)


def roughness_rows(
    names: Sequence[str], sizes: Sequence[int]
) -> Iterator[tuple[dict[str, object], tuple[str, str, float, Mesh, Floats] | None]]:
    """Yield a row of the roughness for each dent, and the dent to be drawn."""
    for name in names:
        material = MATERIALS[name]
        finest = ball(BALLS[max(size for size in sizes if size <= 40962)])
        for radius in TIPS:
            exact = {
                one.depth: facet_roughness(finest.rest_positions, finest.triangles, one.positions)[1]
                for one in settle(finest, material, radius, DEPTHS)
            }
            for size in sizes:
                mesh = ball(BALLS[size])
                for proxy in sorted({0, planned(mesh, material), *(PROXIES if size in PROXIED else ())}):
                    for one in settle(mesh, material, radius, DEPTHS, proxy=proxy):
                        body = {"material": name, "vertices": size, "proxy": proxy, "tip_mm": 1e3 * radius}
                        drawn = (name, _label(size, proxy), one.depth, mesh, one.positions)
                        yield {**body, **roughness(mesh, one, exact[one.depth])}, drawn if radius == TIP else None


def friction_rows(names: Sequence[str], sizes: Sequence[int]) -> Iterator[dict[str, object]]:
    """Yield rows of deep dents in skins of more and more friction, on turned balls and on the proxies of sessions."""
    for name in names:
        for friction in FRICTIONS:
            material = replace(MATERIALS[name], friction=friction)
            bodies = [(_unscaled(rotated(icosphere(4), seed=turn)), 0) for turn in range(2)]
            bodies += [(mesh, planned(mesh, material)) for mesh in (ball(BALLS[size]) for size in sizes if size > 2562)]
            for mesh, proxy in bodies:
                spacing = mean_spacing(mesh, len(mesh.rest_positions))
                for one in settle(mesh, material, TIP, DEPTHS[-2:], proxy=proxy):
                    rough = vertex_roughness(mesh.rest_positions, one.positions, spacing)
                    yield {
                        "friction": friction, "proxy": proxy, "vertices_percent": _percent(rough, one.depth),
                        "material": name, "vertices": len(mesh.rest_positions), "tip_mm": 1e3 * TIP,
                        "depth_mm": 1e3 * one.depth,
                    }  # fmt: skip


def planned(mesh: Mesh, material: Material) -> int:
    """Return how many vertices a session's proxy is requested with, 0 where the full mesh runs live."""
    return plan(build_model(mesh, [material], pinned=base_vertices(mesh)), radius=TIP).asked


def roughness(mesh: Mesh, one: Settled, exact: Profile) -> dict[str, object]:
    """Return how rough a dent on the ball is, over its depth, and how rough an exactly round one would be measured.

    The part of it that is a lean to one side is given too.
    """
    spacing = mean_spacing(mesh, len(mesh.rest_positions))
    rest, round_one = mesh.rest_positions, turned_onto(exact, mesh.rest_positions)
    return {
        "depth_mm": 1e3 * one.depth,
        "vertices_percent": _percent(vertex_roughness(rest, one.positions, spacing), one.depth),
        "vertices_percent_of_round": _percent(vertex_roughness(rest, round_one, spacing), one.depth),
        "lean_percent": _percent(lean(rest, one.positions, spacing), one.depth),
        "facets_percent": _percent(facet_roughness(rest, mesh.triangles, one.positions)[0], one.depth),
        "facets_percent_of_round": _percent(facet_roughness(rest, mesh.triangles, round_one)[0], one.depth),
    }  # fmt: skip


def _percent(part: float, whole: float) -> float:
    return round(100 * part / whole, 3)


def _label(size: int, proxy: int) -> str:
    return f"{size:,}" + (f", proxy {proxy:,}" if proxy else "")


def profiles(solid: str = "neo-hookean") -> dict[tuple[str, float], Profile]:
    """Return the mean dents of the finite elements of one law, by tip and depth [m]."""
    rows = [line.split(",") for line in (KEPT / "solid_dent.csv").read_text("utf-8").splitlines()[1:]]
    found: dict[tuple[str, float], list[list[float]]] = {}
    for body, law, tip, depth, *places in rows:
        if (body, law) == ("ball", solid):
            found.setdefault((tip, round(1e-3 * float(depth), 6)), []).append([1e-3 * float(place) for place in places])
    dents = {}
    for case, places_of in found.items():
        r, z, u_r, u_z = np.array(places_of).T
        dents[case] = Profile(BALL_RADIUS * np.arctan2(r, z + BALL_RADIUS), r + u_r, z + u_z)
    return dents


def solid_materials() -> dict[str, Material]:
    """Return materials full of liquid that answer in proportion, by their spread, none first; a solid; the default."""
    linear = replace(DEFAULT_MATERIAL, K2=DEFAULT_MATERIAL.K1, fill="liquid", density=1000)
    spreads = {f"spread {mm} mm": replace(linear, spread=1e-3 * mm) for mm in (0, 6, 20, 40, 80)}
    solid = {"solid, spread 30 mm": replace(linear, K2=2.1 * linear.K1, x0=0.006, fill="solid", spread=0.03)}
    default = {"default material": DEFAULT_MATERIAL, "default, no spread": replace(DEFAULT_MATERIAL, spread=0.0)}
    return {**spreads, **solid, **default}


def profile_rows(subdivisions: int) -> tuple[list[dict[str, object]], dict[tuple[str, str, float], Profile]]:
    """Return rows of how far the dents of solids and of bodies reach, and their profiles by what, tip and depth."""
    mesh, shapes = ball(subdivisions), {}
    for (tip, depth), solid in profiles().items():
        shapes["finite elements", tip, depth] = solid
    for name, material in solid_materials().items():
        for radius in TIPS:
            for one in settle(mesh, material, radius, (0.005, 0.010, 0.020)):
                spacing = mean_spacing(mesh, len(mesh.rest_positions))
                shape = profile(mesh.rest_positions, one.positions, spacing, within=2.2 * BALL_RADIUS)
                shapes[name, f"ball {1e3 * radius:g} mm", one.depth] = shape
    rows: list[dict[str, object]] = []
    for (name, tip, depth), shape in shapes.items():
        true = shapes.get(("finite elements", tip, depth))
        if true is None:
            continue
        way = np.linspace(0, 0.05, 200)
        off = np.interp(way, shape.way, shape.inward()) - np.interp(way, true.way, true.inward())
        rows.append({
            "body": name, "tip": tip, "depth_mm": 1e3 * depth, "half_mm": round(1e3 * shape.reach(0.5), 2),
            "tenth_mm": round(1e3 * shape.reach(0.1), 2), "bulge_mm": round(1e3 * shape.bulge(), 2),
            "rms_percent_of_depth": _percent(float(np.sqrt(np.mean(off**2))), depth),
        })  # fmt: skip
    return rows, shapes


def _unscaled(made: Shape) -> Mesh:
    """Return a ball whose vertices, not its bounding box, are as far from the centre as those of `ball`."""
    from core.mesh.surface import mesh_from_triangles

    return mesh_from_triangles(made[0] * BALL_RADIUS / np.linalg.norm(made[0], axis=1).max(), made[1])


def add_dents(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_dents)
    command.add_argument("--out", type=Path, default=Path("build/dents"), metavar="DIR", help="where the results go")
    command.add_argument("--materials", nargs="+", choices=MATERIALS, default=list(MATERIALS), help="default: all")
    command.add_argument("--most", type=int, default=163842, metavar="VERTICES", help="of a mesh (default: 163842)")
    command.add_argument(
        "--parts", nargs="+", choices=PARTS, default=PARTS, help="what is measured (default: all)",
    )  # fmt: skip


def run_dents(options: argparse.Namespace) -> int:
    """Measure, print and write each part as CSV, with its pictures beside it."""
    from . import other_tip

    names, sizes = options.materials, [size for size in BALLS if size <= options.most]
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        if "roughness" in options.parts:
            rows, dents = zip(*roughness_rows(names, sizes), strict=True)
            write(list(rows), options.out / "roughness.csv")
            draw_dents([dent for dent in dents if dent], profiles(), options.out)
        if "friction" in options.parts:
            write(list(friction_rows(names, sizes)), options.out / "friction.csv")
        if "profile" in options.parts:
            found, shapes = profile_rows(min(FINE, BALLS[sizes[-1]]))
            write(found, options.out / "profile.csv")
            draw_profiles(shapes, options.out / "profile.png")
        if "other-tip" in options.parts:
            write(list(other_tip.rows(min(FINE, BALLS[sizes[-1]]))), options.out / "other_tip.csv")
    except OSError as error:
        raise DimpleError(f"{options.out} cannot be written: {error.strerror}.") from None
    return 0


def write(rows: Sequence[dict[str, object]], path: Path) -> None:
    """Write rows as CSV and print them."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    print(f"{path}\n{path.read_text(encoding='utf-8')}", flush=True)
