"""What contact costs beside the step without it: near nothing, and with a fifth of the vertices touching.

Bodies that meet and the same bodies alone are led alike and stepped in turn, tick by tick; times are of the processor,
medians over the ticks, so that work beside it hardly counts.
"""

from __future__ import annotations

import time
from statistics import mean, median

import numpy as np

from core.body.model import build_model
from core.constants import OFFSET
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.meshes.bodies import ball
from studies.paper_objects import PRESETS
from studies.reference.proximity import find_pairs, join_surfaces

SOFT = Material(K1=600, K2=4000, x0=0.02, k=400, mass=0.15, friction=0.4)
RADIUS, CELLS = 0.04, 29  # [m]; squares along a side of the cube that a ball is made of: 5,048 vertices
WATER = PRESETS[2]  # the paper's third object, in its size
APART, NEAR = 1.0, 2e-4  # [m] between two balls that meet nothing, and that are to be pressed together
LIGHT, PRESS, AMPLITUDE = 0.004, 0.023, 2e-4  # [m] by which each is led towards the other, and to and fro then
WATER_PRESS = 0.025  # [m], where 1.3 kN press the two together; a fifth of them touches only at 8 kN and more
LEAD, TICKS = 300, 200  # ticks of the way there, and ticks that are measured


def measure_cost() -> dict[str, dict[str, float]]:
    """Return what contact costs.

    Returns:
        for two balls far apart, for two that touch lightly, and for two of which a fifth touches: the time of a tick
        with contact and without [ms], the ratio, both of the mean tick too, for a tick with a query costs several
        without; the substeps of a tick, the vertices of each, and the share of them that touch. Of the paper's vinyl
        full of water, which needs fewer substeps, too.
    """
    return {
        "near_nothing": _measured(0.0),
        "lightly_touching": _measured(LIGHT),
        "fifth_touching": _measured(PRESS),
        "water_lightly_touching": _measured(LIGHT, WATER.material, WATER.size / 2),
        "water_tenth_touching": _measured(WATER_PRESS, WATER.material, WATER.size / 2),
    }


def press(tick: int, depth: float = PRESS) -> float:
    """Return by how much the pins are led at a tick [m]: on their way, then to and fro."""
    return depth * min(tick / LEAD, 1.0) + AMPLITUDE * np.sin(0.05 * max(tick - LEAD, 0))


def lead_together(sessions: list[Session], depth: float) -> None:
    """Lead two balls towards each other, each by a depth [m] from where it began."""
    for session, side in zip(sessions, (-1, 1), strict=True):
        session.set_pins(session.model.mesh.rest_positions - (0, 0, side * depth))


def bodies(gap: float, material: Material = SOFT, radius: float = RADIUS) -> list[Session]:
    """Return two balls a distance apart [m], each pinned on its far side."""
    mesh = ball(CELLS, 2 * radius)
    points, faces = mesh.rest_positions, mesh.triangles
    found = []
    for side in (-1, 1):
        pinned = points[:, 2] * side > 0.6 * radius
        placed = points + (0, 0, side * (radius + gap / 2))
        found.append(Session(build_model(mesh_from_triangles(placed, faces), [material], pinned=pinned)))
    return found


def _measured(depth: float, material: Material = SOFT, radius: float = RADIUS) -> dict[str, float]:
    """Measure balls that are led towards each other by a depth [m] each; 0: that stay far apart."""
    meeting, alone = (bodies(NEAR if depth else APART, material, radius) for _ in range(2))
    floor = Collider(np.array([[-1.0, 1, 0], [0, 0, 1], [-2, -2, -2]]), np.array([[0, 1, 2]]))
    world, spent, free = World(meeting, [floor], itself=[False, False]), [], []
    substeps = max(session.substeps for session in meeting)
    for tick in range(LEAD + TICKS):
        for sessions in (meeting, alone):
            lead_together(sessions, press(tick, depth) if depth else 0.0)
        began = time.process_time()
        world.step(meeting[0].clock.tick)
        between = time.process_time()
        for session in alone:
            session.step(session.clock.tick)
        ended = time.process_time()
        if tick >= LEAD:
            spent.append(between - began)
            free.append(ended - between)
    touching = _touching(meeting)
    return {
        "with_ms": round(1e3 * median(spent), 3), "alone_ms": round(1e3 * median(free), 3),
        "ratio": round(median(a / b for a, b in zip(spent, free, strict=True)), 2),
        "mean_ms": round(1e3 * mean(spent), 3), "mean_ratio": round(sum(spent) / sum(free), 2), "substeps": substeps,
        "vertices": len(meeting[0].model.mesh.rest_positions), "touching": round(touching, 3),
    }  # fmt: skip


def _touching(sessions: list[Session]) -> float:
    """Return the share of vertices that are as near to the other body as touches, within a tenth."""
    x = [session.body.positions().T for session in sessions]
    s = join_surfaces([session.model.mesh.rest_positions for session in sessions],
                      [session.model.mesh.triangles for session in sessions])  # fmt: skip
    both, reach = np.concatenate(x), 2.2 * OFFSET * float(s.edge.mean())
    pairs = find_pairs(s, both, 0, 1, reach=reach, closest=0.0)
    return len(np.unique(pairs.at[pairs.ones == 1, 0])) / len(both)
