"""Press the same bodies with Dimple and with Bullet, in turn: `python3 dev.py bench --peers`.

A press is one simulated second with a control tick of 1 ms: the fingertip 20 mm down, still, up and away. Its cost is
processor time, the median over repeats. Volume and skin are judged while the fingertip is still, by trimesh for all.
Bullet runs with ten iterations of its position solver, as where its cost was first compared, and with one, its default:
faster, and the skin stretches and sinks in more.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt
import trimesh

from core.mesh.surface import input_vertices
from core.session import Session
from studies import scenes
from tests.bench import bullet

TICK = 1e-3  # [s]
DEPTH = 0.020  # [m]
SEEN = range(300, 501, 50)  # ticks after which volume and skin are judged: the fingertip has been still for a while
REPEATS = 5
ITERATIONS = {"bullet": 10, "bullet_1": 1}  # of Bullet's position solver in a tick

BODIES: tuple[tuple[str, Callable[[], Session]], ...] = (
    ("poke_ball", lambda: scenes.poke_ball(3)),
    ("poke_ball", lambda: scenes.poke_ball(4)),
    ("poke_ball", lambda: scenes.poke_ball(5)),
    ("poke_cube", lambda: scenes.poke_cube(20)),
)

Floats = npt.NDArray[np.float64]


def measure(scene: str, session: Session) -> dict[str, Any]:
    """Return what pressing a body costs Dimple and Bullet, and how well each keeps volume and skin."""
    model = session.model
    rest, triangles = model.mesh.rest_positions, model.mesh.triangles
    centres, mass = path(rest), float(model.mass.sum())
    costs: dict[str, list[float]] = {"dimple": [], **{name: [] for name in ITERATIONS}}
    found: dict[str, Floats] = {}
    for _ in range(REPEATS):
        cost, found["dimple"] = press(session)
        costs["dimple"].append(cost)
        for name, iterations in ITERATIONS.items():
            theirs = bullet.press(
                rest, triangles, model.pinned, mass, centres, scenes.FINGERTIP, tick=TICK, seen=SEEN,
                iterations=iterations,
            )  # fmt: skip
            costs[name].append(theirs.cost)
            found[name] = theirs.positions
    row: dict[str, Any] = {"scene": scene, "vertices": len(rest)}
    row |= {f"{name}_cpu_ms": round(1000 * median(some), 1) for name, some in costs.items()}
    for name in ITERATIONS:
        row[name.replace("bullet", "ratio")] = round(median(costs[name]) / median(costs["dimple"]), 3)
    for name, positions in found.items():
        row |= {f"{name}_{key}": value for key, value in verdict(rest, triangles, positions, centres[SEEN[0]]).items()}
    return row


def path(rest: Floats) -> Floats:
    """Return the centres (ticks + 1, 3) [m] of the fingertip in `scenes.poke`."""
    times, shares = zip((0.0, 0.0), *scenes.POKE, strict=True)
    down = DEPTH * np.interp(np.arange(round(times[-1] / TICK) + 1) * TICK, times, shares)
    return np.stack([0 * down, 0 * down, rest[:, 2].max() + scenes.FINGERTIP - down], axis=1)


def press(session: Session) -> tuple[float, Floats]:
    """Press a body with Dimple.

    Returns:
        processor time [s], and positions (k, n, 3) [m] after the ticks that are judged.
    """
    session.reset()
    cost, found, which = 0.0, [], input_vertices(session.model.mesh)
    started = time.process_time()
    for i, _ in enumerate(scenes.poke(session, depth=DEPTH, frame_rate=1 / TICK), 1):
        if i in SEEN:
            cost += time.process_time() - started
            found.append(session.positions()[which].astype(np.float64))
            started = time.process_time()
    return cost + time.process_time() - started, np.array(found)


def verdict(rest: Floats, triangles: npt.NDArray[np.integer], positions: Floats, centre: Floats) -> dict[str, float]:
    """Return the worst over some moments (k, n, 3) [m].

    Returns:
        volume_error_percent, penetration_mm: how far the nearest point of the surface lies inside the fingertip, and
        dent_mm: how far the pole has gone down, 20 where the skin is under the fingertip.
    """
    volumes = [trimesh.Trimesh(x, triangles, process=False).volume for x in (rest, *positions)]
    nearest = [trimesh.triangles.closest_point(x[triangles], np.tile(centre, (len(triangles), 1))) for x in positions]
    inside = [scenes.FINGERTIP - np.linalg.norm(points - centre, axis=1).min() for points in nearest]
    pole = np.linalg.norm(rest - (0, 0, rest[:, 2].max()), axis=1).argmin()
    return {
        "volume_error_percent": round(100 * float(np.abs(np.array(volumes[1:]) / volumes[0] - 1).max()), 5),
        "penetration_mm": round(1000 * float(max(inside)), 4),
        "dent_mm": round(1000 * float((rest[pole, 2] - positions[:, pole, 2]).min()), 2),
    }


def measure_all() -> list[dict[str, Any]]:
    """Measure every body, print a line for each and return them."""
    print("Dimple, Bullet with 10 iterations, Bullet with 1; ratios: Bullet's time over Dimple's")
    print("scene      vertices   CPU ms of one second      ratios     volume error %        penetration mm     dent mm")
    rows = []
    for scene, make in BODIES:
        rows.append(measure(scene, make()))
        print(line(rows[-1]), flush=True)
    return rows


def line(row: dict[str, Any]) -> str:
    names = ("dimple", *ITERATIONS)
    quality = "   ".join(
        " ".join(f"{row[f'{name}_{key}']:{digits + 3}.{digits}f}" for name in names)
        for key, digits in (("volume_error_percent", 3), ("penetration_mm", 2), ("dent_mm", 1))
    )
    cost = " ".join(f"{row[f'{name}_cpu_ms']:7.0f}" for name in names)
    return f"{row['scene']:10} {row['vertices']:8} {cost}   {row['ratio']:5.2f} {row['ratio_1']:5.2f}   {quality}"
