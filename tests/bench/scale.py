"""Measure what many bodies and many vertices cost: `python3 dev.py bench --scale [--json FILE]`.

Times are medians, of processor time but for the workers, whose wall time is what they are for: on a machine that does
other work too, two of them have less than two cores. The full mesh of a million vertices is pressed only with
--full, for it takes minutes.
"""

from __future__ import annotations

import hashlib
import resource
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from statistics import median
from typing import Any

import numpy as np

from core import native
from core.base import TICK
from core.body.model import build_model
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.native.body import step_many
from core.native.motion import Motion
from core.reduction.binding import carry
from core.reduction.proxy_rule import plan
from core.session import Finger, Session, step_all
from studies import scenes
from studies.body.presses import Press, dent_error, pressed
from studies.meshes import bodies
from tests.bench.bench import stir, straight

FRAME = 1 / 60  # [s]
CROWD, TOUCHED, FRAMES = 100, 5, 12
# how many bodies, of how many vertices
WORKERS_BODIES = (8, 2562), (32, 642), (3, 10_242), (5, 10_242), (20, 10_242), (1, 10_242), (1, 40_962)
TURNS, CALLS = 15, 4  # of each: with one worker, with two, then two processes that share nothing
SPEEDS, HELD = (40, 10, 4), 30  # of a live press [mm/s]; frames
MILLION, SIZE, RADIUS = 408, 0.2, 0.016  # squares along a side of the head; [m]
TOP = scenes.BALL_RADIUS + scenes.FINGERTIP


def crowd() -> dict[str, float]:
    """Return what a hundred bodies cost of which five are touched, over the five alone; and all over their share."""
    groups = [scenes.poke_ball(4) for _ in range(TOUCHED)], [scenes.poke_ball(4) for _ in range(CROWD)]
    alone, five = frames([(groups[0], TOUCHED), (groups[1], TOUCHED)])
    once, every = frames([(groups[0], TOUCHED), (groups[1], CROWD)])
    return {
        "five_alone_ms": round(1e3 * median(alone), 3),
        "five_of_100": round(median(b / a for a, b in zip(alone, five, strict=True)), 3),
        "all_of_100": round(median(b / a for a, b in zip(once, every, strict=True)) * TOUCHED / CROWD, 3),
    }  # fmt: skip


def frames(groups: Sequence[tuple[Sequence[Session], int]]) -> list[list[float]]:
    """Return processor times [s] of frames: a fingertip goes into the first bodies of each group, group by group."""
    for sessions, _ in groups:
        for session in sessions:
            session.reset()
            session.set_fingers([])
            session.step(0.4)  # it falls asleep
            session.positions()
    costs: list[list[float]] = [[] for _ in groups]
    for frame in range(FRAMES):
        for (sessions, touched), cost in zip(groups, costs, strict=True):
            started = time.process_time()
            for i, session in enumerate(sessions):
                tip = Finger((0.0, 0.0, TOP - 1e-3 * frame), scenes.FINGERTIP)
                session.set_fingers([tip] if i < touched else [])
            step_all(sessions, [FRAME] * len(sessions))
            for session in sessions:
                session.positions()
            cost.append(time.process_time() - started)
    return costs


def workers() -> dict[str, Any]:
    """Return what two workers come to on several crowds: see `two_workers`."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = {f"{count} x {size:,}": two_workers(pool, count, size) for count, size in WORKERS_BODIES}
    return found | {"same_hash": all(each["same_hash"] for each in found.values())}


def two_workers(pool: ProcessPoolExecutor, count: int, size: int) -> dict[str, Any]:
    """Return the wall time of a call with one worker and with two, and whether all bits are the same.

    The ceiling is how much faster two processes that share nothing step than one: what this machine has to give. It is
    measured turn by turn beside the calls: twice the wall time of one process over that of two at once.
    """
    groups = {workers: pressed_crowd(count, size) for workers in (1, 2)}
    times: dict[int, list[float]] = {1: [], 2: []}
    ceilings = []
    list(pool.map(stepping, (count, count), (size, size)))
    for turn in range(TURNS):
        for call in range(CALLS):
            for workers in (1, 2) if (turn + call) % 2 else (2, 1):
                stir_all(groups[workers])
                started = time.perf_counter()
                press_on(groups[workers], workers)
                times[workers].append(time.perf_counter() - started)
        alone = pool.submit(stepping, count, size).result()
        ceilings.append(2 * alone / max(pool.map(stepping, (count, count), (size, size))))
    hashes = {
        hashlib.sha256(b"".join(body.positions().tobytes() for body in group)).hexdigest() for group in groups.values()
    }
    return {
        "vertices": count * size, "one_ms": round(1e3 * median(times[1]), 2),
        "two_ms": round(1e3 * median(times[2]), 2), "least_ms": [round(1e3 * min(times[k]), 2) for k in (1, 2)],
        "ratio": round(median(a / b for a, b in zip(times[1], times[2], strict=True)), 3),
        "ceiling": round(median(ceilings), 3), "same_hash": len(hashes) == 1,
    }  # fmt: skip


def pressed_crowd(count: int, size: int) -> list[native.Body]:
    """Return balls with a number of vertices, each under a fingertip 10 mm deep."""
    subdivisions = round(np.log(size / 10) / np.log(4))  # 10 * 4**n + 2 vertices
    model = scenes.poke_ball(subdivisions).model
    group = [native.Body(model, native.library()) for _ in range(count)]
    down = Motion(8, model.substeps(TICK), TICK, straight(TOP, TOP - 0.01, 8, 1))
    native.library().dm_set_workers(1)
    step_many(group, [down] * count)
    return group


def stir_all(group: Sequence[native.Body]) -> None:
    """Wake pressed balls, untimed: what rests costs nothing."""
    for body in group:
        stir(body)
    press_on(group, 1, ticks=1)


def press_on(group: Sequence[native.Body], workers: int, ticks: int = 8) -> None:
    """Step pressed balls by half a frame."""
    still = Motion(ticks, group[0].model.substeps(TICK), TICK, straight(TOP - 0.01, TOP - 0.01, ticks, 1))
    native.library().dm_set_workers(workers)
    step_many(group, [still] * len(group))


def stepping(count: int, size: int) -> float:
    """Return the wall time [s] of calls that step a crowd on one worker, in this process."""
    if (count, size) not in _crowds:
        _crowds.clear()
        _crowds[count, size] = pressed_crowd(count, size)
    spent = 0.0
    for _ in range(CALLS):
        stir_all(_crowds[count, size])
        started = time.perf_counter()
        press_on(_crowds[count, size], 1)
        spent += time.perf_counter() - started
    return spent


_crowds: dict[tuple[int, int], list[native.Body]] = {}  # of a process beside


def million(*, full: bool) -> dict[str, Any]:
    """Return what a head of a million vertices takes to set up and to press live by its proxy, and how near that is."""
    made = bodies.head(MILLION, SIZE)
    points, triangles = made.rest_positions, made.triangles
    del made
    started, spent = time.perf_counter(), time.process_time()
    mesh = mesh_from_triangles(points, triangles)
    meshed = time.perf_counter()
    model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
    modelled = time.perf_counter()
    chosen = plan(model, radius=RADIUS, budget=scenes.BUDGET)
    planned = time.perf_counter()
    print(f"plan in {planned - modelled:.3f} s: {chosen.reason}", flush=True)
    session = Session(model, proxy=chosen.proxy)
    ready, spent = time.perf_counter(), time.process_time() - spent
    at = int(mesh.rest_positions[:, 2].argmax())
    outward = np.array([0.0, 0.0, 1.0])
    press = Press(at=mesh.rest_positions[at], outward=outward, radius=RADIUS, depth=RADIUS / 2)
    frames_ms = live(session, press)
    found: dict[str, Any] = {
        "vertices": len(mesh.rest_positions), "moving": len(session.body.model.mass),
        "mesh_s": round(meshed - started, 2), "model_s": round(modelled - meshed, 2),
        "plan_s": round(planned - modelled, 3),
        "setup_s": round(ready - started, 2), "setup_cpu_s": round(spent, 2),
        "frame_ms": frames_ms[f"{SPEEDS[0]} mm/s"], "frames_ms": frames_ms,
        "memory_gb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, 3),
        "surface_error": None,
    }  # fmt: skip
    if full and chosen.proxy:
        ours = carry(chosen.proxy.binding, pressed(chosen.proxy.model, press))
        error = dent_error(mesh, ours, pressed(model, press).T)
        found["surface_error"] = round(error / RADIUS, 4)
    return found


def live(session: Session, press: Press) -> dict[str, float]:
    """Return what a frame of a press takes in the median [ms], step and skin, by its speed, held and released."""
    found = {}
    for speed in SPEEDS:
        session.reset()
        count = round(60e3 * press.depth / speed)
        parts: dict[str, list[int | None]] = {f"{speed} mm/s": list(range(1, count + 1))}
        if speed == SPEEDS[0]:
            parts |= {"held": [count] * HELD, "released": [None] * HELD}
        for part, depths in parts.items():
            costs = []
            for depth in depths:
                where = press.at + press.outward * (press.radius - press.depth * (depth or 0) / count)
                session.set_fingers([None if depth is None else Finger(tuple(where.tolist()), press.radius)])
                began = time.process_time()
                session.step(FRAME)
                session.positions()
                costs.append(time.process_time() - began)
            found[part] = round(1e3 * median(costs), 2)
    return found


def main(*, full: bool) -> dict[str, Any]:
    """Measure all, print each as it is known and return it."""
    found: dict[str, Any] = {}
    # the million first: its memory is the most that the process has had
    for name, measure in (("million", lambda: million(full=full)), ("crowd", crowd), ("workers", workers)):
        found[name] = measure()
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in found[name].items()), flush=True)
    return found
