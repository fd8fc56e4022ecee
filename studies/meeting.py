"""Bodies that proxies move beside the same in full, where they meet: `python3 dev.py core meeting [--full] [BODY...]`

A plate, a ball, a weight of 0.5 kg, and for the balls of 5,048 vertices another body meet each. What is simulated is
what the planner takes for a scene of so many bodies with contact. With --full every vertex is simulated too, which
takes minutes: forces, depths and processor times are then compared.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

from core.base import Floats
from core.body.model import build_model
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.reduction.proxy_rule import BUDGET, Plan, plan, plan_full_mesh
from core.session import Session
from core.world import Collider, World

from . import bodies, contact_cost
from .primitives import icosphere, sized

CONTACT = 2.0  # as in operators/press/object_plan.py
DEPTH, GAP, RADIUS, FRAME, TIP = 0.015, 0.003, 0.02, 1 / 60, 0.01
SIDES, WEIGHT, DOWN_S, HOLD_S, REST_S = (0.06, 0.06, 0.03), 0.5, 0.3, 0.15, 1.5
MESHES = {
    "ball": lambda: sized(*icosphere(6), 0.16),  # 40,962 vertices
    "head": lambda: bodies.head(158, 0.2),  # 149,786
    "scan": lambda: bodies.scan(82, 0.2),  # 40,346, rough
}


def add_meeting(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("body", nargs="*", help=f"{', '.join(MESHES)} or pair; all if none is named")
    parser.add_argument("--full", action="store_true", help="simulate every vertex too")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print of each body and scene what moves, how far the mesh shown overlaps, force, depth and processor time."""
    for name in options.body or [*MESHES, "pair"]:
        if name == "pair":
            pair(full=options.full)
            continue
        mesh = MESHES[name]()
        model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
        planned = plan(model, radius=TIP, budget=BUDGET / CONTACT)
        print(f"{name}, {len(model.mass):,} vertices. {planned.reason}", flush=True)
        for chosen in (planned, plan_full_mesh(model))[: 1 + options.full]:
            for scene in ("plate", "ball", "weight"):
                session = Session(model, proxy=chosen.proxy)
                moving = len(session.body.model.mass)
                print(f"  {scene}, {moving:,} vertices: {meet(scene, session)}", flush=True)
    return 0


def meet(scene: str, body: Session) -> str:
    """Let a body meet something from above; return what came of it in words."""
    mesh, spent, overlaps = body.model.mesh, 0.0, []
    top = mesh.rest_positions[mesh.rest_positions[:, 2].argmax()]
    other, reach = _other(scene)
    start = other.rest_positions + top + (0, 0, GAP)
    collider = Collider(start.T.copy(), other.triangles)
    weight = scene == "weight"
    world = World([body], [collider], masses=[WEIGHT]) if weight else World([body], [collider])
    for frame in range(1, round((REST_S if weight else DOWN_S + HOLD_S) / FRAME) + 1):
        if not weight:
            world.set_colliders([start - (0, 0, (DEPTH + GAP) * min(frame * FRAME / DOWN_S, 1.0))])
        began = time.process_time()
        meeting = world.step(FRAME)
        spent += time.process_time() - began
        pose = world.props[0].pose() if world.props else np.eye(4)
        way = np.zeros(3) if weight else world.collider(0)[0] - start[0]
        seen = (body.positions().astype(np.float64) - pose[:3, 3]) @ pose[:3, :3] - (top + (0, 0, GAP) + way)
        overlaps.append(1e3 * float(reach(seen).max()))
    depth = f"depth {-1e3 * world.props[0].pose()[2, 3] - 1e3 * GAP:.2f} mm" if world.props else ""
    return (
        f"overlap {overlaps[-1]:.2f} mm at the end, {max(overlaps):.2f} at most, "
        f"{depth or f'force {-meeting.forces[0, 2]:.2f} N'}, {spent / body.frame.time:.2f} s a second"
    )


def _other(scene: str) -> tuple[Mesh, Any]:
    """Return what a body meets, its lowest point in the origin, and how deep points (n, 3) are in it as it is seen."""
    if scene == "plate":
        plate = np.array([(-0.3, -0.3, 0), (0.3, -0.3, 0), (0.3, 0.3, 0), (-0.3, 0.3, 0)])
        return mesh_from_triangles(plate, np.array([(0, 2, 1), (0, 3, 2)])), lambda x: x[:, 2]
    if scene == "ball":
        round_one = sized(*icosphere(4), 2 * RADIUS)
        up = np.array([0, 0, -round_one.rest_positions[:, 2].min()])
        return _lifted(round_one, up), lambda x: RADIUS - np.linalg.norm(x - up, axis=1)
    half = np.array(SIDES) / 2
    block = bodies.box(1, 1.0)
    centred = block.rest_positions - block.rest_positions.mean(axis=0)
    up = np.array([0, 0, half[2]])
    corners = mesh_from_triangles(2 * half * centred + up, block.triangles)
    return corners, lambda x: (half - np.abs(x - up)).min(axis=1)


def _lifted(mesh: Mesh, up: Floats) -> Mesh:
    return mesh_from_triangles(mesh.rest_positions + up, mesh.triangles)


def pair(*, full: bool) -> None:
    """Print what a tick of two balls of 5,048 vertices costs, a fifth of each touching."""
    print("pair, two balls of 5,048 vertices, a fifth of which touches")

    def planned(session: Session) -> Plan:
        return plan(session.model, budget=BUDGET / 2 / CONTACT)

    print(f"  {planned(contact_cost.bodies(contact_cost.NEAR)[0]).reason}")
    for proxies in (True, False)[: 1 + full]:
        made = contact_cost.bodies(contact_cost.NEAR)
        sessions = [Session(each.model, proxy=planned(each).proxy) if proxies else each for each in made]
        world, spent = World(sessions), []
        for tick in range(contact_cost.LEAD + contact_cost.TICKS):
            contact_cost.lead_together(sessions, contact_cost.press(tick))
            began = time.process_time()
            meeting = world.step(sessions[0].clock.tick)
            spent.append(time.process_time() - began)
        ticks = 1e3 * np.array(spent[contact_cost.LEAD :])
        moving = len(sessions[0].body.model.mass)
        print(
            f"  {moving:,} vertices each: a tick takes {np.median(ticks):.2f} ms in the median, {ticks.mean():.2f} in "
            f"the mean; force {abs(meeting.forces[0, 2]):.1f} N", flush=True,
        )  # fmt: skip
