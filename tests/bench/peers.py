"""One simulated second of the scenes other solvers were measured on: `python3 dev.py bench --peers`."""

from __future__ import annotations

import time

import numpy as np

from core.body.contact import nearest_on_triangles
from core.mesh.surface import input_vertices
from core.session import Session
from studies import scenes

HOLD = (0.3, 0.5)  # [s] the fingertip has been still for a while
DEPTH = 0.020  # [m]


def scene_line(name: str, session: Session) -> str:
    """Return what a press, a hold and a lift cost, and how well volume and skin are kept at hold."""
    mesh, cost, volume, sunk = session.model.mesh, 0.0, 0.0, 0.0
    centre = np.array([0.0, 0.0, mesh.rest_positions[:, 2].max() + scenes.FINGERTIP - DEPTH])
    started = time.process_time()
    for frame in scenes.poke(session, depth=DEPTH):
        cost += time.process_time() - started
        if HOLD[0] <= frame.time <= HOLD[1]:
            volume = max(volume, abs(frame.volume / frame.rest_volume - 1))
            x = session.positions().astype(float)[input_vertices(mesh)].T
            corners = x[:, mesh.triangles]
            nearest = (corners * nearest_on_triangles(corners, centre)).sum(axis=2).T
            sunk = max(sunk, scenes.FINGERTIP - float(np.linalg.norm(nearest - centre, axis=1).min()))
        started = time.process_time()
    n = len(mesh.rest_positions)
    return f"{name:10} {n:8} {session.substeps:9} {1000 * cost:8.0f} {100 * volume:14.3f} {1000 * sunk:16.3f}"


def main() -> int:
    print("scene      vertices  substeps  CPU ms  volume error %  penetration mm   (1 s, 1 ms ticks, one core)")
    for size in (3, 4, 5):
        print(scene_line("poke_ball", scenes.poke_ball(size)), flush=True)
    print(scene_line("poke_cube", scenes.poke_cube(20)), flush=True)
    return 0
