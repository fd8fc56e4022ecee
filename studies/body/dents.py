"""`dev.py core dents`: how smooth settled dents are, and how near the force and dents of a solid to finite elements."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.base import Floats
from core.body.estimate import estimate
from core.body.model import Model, build_model
from core.material import DEFAULT_MATERIAL, Material
from core.mesh.surface import Mesh, base_vertices
from core.reduction.proxy import build_proxy, mean_spacing
from core.reduction.proxy_rule import plan
from core.session import Finger, Session
from studies.body.dent_shape import vertex_roughness
from studies.body.solid_mesh import BALL_RADIUS
from studies.files import aligned, write_csv
from studies.meshes.simple import icosphere, sized
from studies.scenes import BUDGET

TIP = 0.010  # [m] radius of the fingertip
DEPTHS = (0.005, 0.010, 0.015, 0.020, 0.025)  # [m]
FRICTIONS = (0.5, 2.0)  # of the skin
RATE = 500.0  # [1/s] at which a body as light and damped as these settles
TRAVEL = 0.1  # [m/s] of the fingertip
SETTLING = 0.07  # [s] at each depth


@dataclass(frozen=True, slots=True)
class Settled:
    """A body at rest under a fingertip.

    depth: of the tip below the surface at rest [m].
    force: on the tip [N].
    positions: of the vertices of the mesh (n, 3) [m].
    """

    depth: float
    force: float
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
        frame = session.step(SETTLING)
        at = depth
        yield Settled(depth, float(np.linalg.norm(frame.finger_forces[0])), session.skin())


def ball(subdivisions: int) -> Mesh:
    """Return the ball of the finite elements, an icosphere."""
    return sized(*icosphere(subdivisions), 2 * BALL_RADIUS)


def planned(mesh: Mesh, material: Material) -> int:
    """Return how many vertices a session's proxy is requested with, 0 where the full mesh runs live."""
    return plan(build_model(mesh, [material], pinned=base_vertices(mesh)), radius=TIP, budget=BUDGET).asked


def roughness(mesh: Mesh, one: Settled) -> float:
    """Return how far the vertices of a dent are from the mean of their rings (RMS), over its depth."""
    spacing = mean_spacing(mesh, len(mesh.rest_positions))
    return vertex_roughness(mesh.rest_positions, one.positions, spacing) / one.depth


def roughness_rows(subdivisions: Sequence[int]) -> Iterator[tuple[object, ...]]:
    """Yield the roughness [%] of dents on meshes and on the proxies of sessions, by friction and depth [mm]."""
    for friction in FRICTIONS:
        material = replace(DEFAULT_MATERIAL, friction=friction, spread=None)
        for mesh in map(ball, subdivisions):
            for proxy in sorted({0, planned(mesh, material)}):
                for one in settle(mesh, material, TIP, DEPTHS, proxy=proxy):
                    rough = round(100 * roughness(mesh, one), 3)
                    yield len(mesh.rest_positions), proxy, friction, 1e3 * one.depth, rough


def add_dents(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_dents)
    command.add_argument("--out", type=Path, default=Path("build/dents"), metavar="DIR", help="where the results go")
    command.add_argument("--quick", action="store_true", help="on coarse meshes: under a minute")


def run_dents(options: argparse.Namespace) -> int:
    """Measure both, print and write them as CSV, and draw the comparison with finite elements."""
    from studies.body import beside_solid

    options.out.mkdir(parents=True, exist_ok=True)
    head = ("vertices", "of_proxy", "friction", "depth_mm", "roughness_percent")
    for name, header, rows in (
        ("roughness", head, list(roughness_rows((4,) if options.quick else (4, 5, 6)))),
        ("beside_solid", beside_solid.HEAD, list(beside_solid.rows(4 if options.quick else 5))),
    ):
        write_csv(options.out / f"{name}.csv", header, rows)
        print(name + "\n" + aligned([header, *([str(cell) for cell in row] for row in rows)]), flush=True)
    beside_solid.draw(options.out, 4 if options.quick else 5)
    return 0
