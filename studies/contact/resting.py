"""`dev.py core props`: how deep props rest in soft bodies, whole and cut, beside the closed form of the bed.

The closed form knows a wide flat surface and the bed with its tension: kappa (A + P s) for a flat prop of area A and
perimeter P, `bed_area` for a ball. The fill and the sides of a body are not in it, so it is compared with a wide slab
that is filled with nothing first.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import trimesh

from core.body.estimate import bed_area, estimate, falloff, spread_on
from core.body.model import build_model
from core.material import STANDARD_GRAVITY, Indenter
from core.mesh.surface import Mesh, mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.contact.led import MATERIAL, MIDDLE, SIDE
from studies.meshes.simple import cube

TIP = Indenter(shape="punch", radius=SIDE / 16)  # of the measurement: the same bed whatever the size of the body
MASSES, CUTS = (0.5, 2.0, 6.0), (0, 2)  # [kg]; subdivisions of a prop
WIDE, CELLS, SLAB_CELLS = 2.0, 16, 28  # width of the slab in sides of the cube; squares along a side of each
SQUARE, RADIUS, HEIGHT, ABOVE = 0.06, 0.03, 0.02, 0.002  # [m] of the flat prop, of the ball, and where they fall from
SECONDS = 2.0  # until they rest


def square() -> trimesh.Trimesh:
    """Return a flat box."""
    return trimesh.creation.box((SQUARE, SQUARE, HEIGHT))


def ball() -> trimesh.Trimesh:
    """Return a ball."""
    return trimesh.creation.icosphere(3, RADIUS)


PROPS: dict[str, Callable[[], trimesh.Trimesh]] = {"box": square, "ball": ball}


def block(wide: float, cells: int) -> Mesh:
    """Return a block of the cube's height, with its top at a height of 0."""
    made = cube(cells, 1.0)
    x = made.rest_positions * [wide * SIDE, wide * SIDE, SIDE] - [0, 0, SIDE / 2]
    return mesh_from_triangles(x, made.triangles)


BODIES: dict[str, tuple[Callable[[], Mesh], str]] = {
    "slab, none": (lambda: block(WIDE, SLAB_CELLS), "none"),
    "slab, air": (lambda: block(WIDE, SLAB_CELLS), "air"),
    "cube, none": (lambda: block(1.0, CELLS), "none"),
    "cube, air": (lambda: block(1.0, CELLS), "air"),
}


def rest(prop: str, mass: float, cuts: int, body: str) -> float:
    """Return how deep [m] the lowest place of a prop rests below a body's top."""
    (make, fill), made = BODIES[body], PROPS[prop]()
    for _ in range(cuts):
        made = made.subdivide()
    low = float(made.vertices[:, 2].min())
    start = np.array(made.vertices) + [*MIDDLE, ABOVE - low]
    mesh, material = make(), replace(MATERIAL, indenter=TIP, fill=fill)
    session = Session(build_model(mesh, [material], pinned=mesh.rest_positions[:, 2] < -SIDE + 1e-6))
    world = World([session], [Collider(start.T.copy(), np.array(made.faces))], masses=[mass])
    world.step(SECONDS)
    return -float(world.props[0].state.centre[2]) - low


def wanted(prop: str, mass: float) -> float:
    """Return how deep [m] it rests by the closed form, up to the knee of the bed; beyond, nan."""
    constants, spread = estimate(MATERIAL, SIDE), spread_on(MATERIAL, SIDE)
    depths = np.linspace(1e-5, constants.d0, 2000)
    if prop == "box":
        area = SQUARE**2 + 4 * SQUARE * falloff(SQUARE / math.sqrt(math.pi), spread)  # as round as it is large
        forces = constants.kappa1 * area * depths
    else:
        tip = Indenter(shape="sphere", radius=RADIUS)
        forces = constants.kappa1 * np.array([bed_area(tip, SIDE, spread, x)[0] * x for x in depths.tolist()])
    return float(np.interp(mass * STANDARD_GRAVITY, forces, depths, right=math.nan))


def add_props(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_props)
    command.add_argument("--bodies", nargs="+", choices=BODIES, default=list(BODIES), metavar="BODY")


def run_props(options: argparse.Namespace) -> int:
    """Print how deep each prop rests."""
    print("body        prop    kg  whole  cut [mm]  cut / whole  closed form [mm]  whole / closed form")
    for body in options.bodies:
        for prop in PROPS:
            for mass in MASSES:
                whole, cut = (rest(prop, mass, cuts, body) for cuts in CUTS)
                form = wanted(prop, mass)
                print(
                    f"{body:11} {prop:5} {mass:4g} {1e3 * whole:6.2f} {1e3 * cut:6.2f} {cut / whole:15.3f}"
                    f" {1e3 * form:17.2f} {whole / form:20.3f}",
                    flush=True,
                )
    return 0
