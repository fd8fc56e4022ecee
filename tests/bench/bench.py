"""Measure a step: scenes x sizes x backends, in one run. `python3 dev.py bench [--quick] [--json FILE]`

A timing here is processor time of one core, the median over repeats that go round the backends in turn, so that a
busy machine slows them alike; the least is beside it. Ratios within a run are what to compare. The full run keeps a
CSV and a chart per machine.
"""

from __future__ import annotations

import csv
import ctypes
import gc
import os
import platform
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from core import native
from core.base import Floats
from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import Mesh, base_vertices
from core.native import Body
from core.native.motion import FingertipMotion, Motion
from core.session import Finger, Session
from studies.motions import straight
from studies.paper_objects import PRESETS
from studies.reference.twin import Twin
from studies.scenes import BALL, BALL_RADIUS, FINGERTIP, ball, cube
from tests.bench.chart import draw

TICK = 1e-3  # [s]
DEPTH = 0.010  # [m] of the press that is measured
PRESS_TICKS = 8  # from the skin to there
TICKS_AT_ONCE = 8  # of a call: half a frame at 60 Hz
BALL_SIZES, CUBE_SIZES = (3, 4, 5, 6, 7), (10, 20, 41, 82, 165)  # 642 or 602 vertices to 164 thousand
SUBSTEPS = 10  # in a tick, for "N vertices in real time"
CALLS_MS = (1.0, 1000 / 60)  # of a session: a servo's, or another solver's user's; and a viewport's
SESSION_LIMIT = 12_000  # vertices of the largest body that is stepped through a session too

WORLD = {"gravity": (0.0, 0.0, -9.81), "ground": -BALL_RADIUS}

# scene: mesh of a size, material, held by its base, number of fingertips, sizes, and further arguments of build_model
SCENES: dict[str, tuple[Callable[[int], Mesh], Material, bool, int, tuple[int, ...], dict[str, Any]]] = {
    "poke_ball": (ball, BALL, True, 1, BALL_SIZES, {}),
    "free_ball": (ball, BALL, False, 0, BALL_SIZES, {}),
    "poke_cube": (lambda cells: cube(cells, PRESETS[2].size), PRESETS[2].material, True, 1, CUBE_SIZES, {}),
    "everything": (ball, BALL, False, 1, BALL_SIZES, WORLD),
}
KINDS: dict[str, dict[str, Any]] = {
    "native": {"bits": 32},
    "native, no AVX": {"bits": 32, "instruction_set": native.BASE},
    "native64": {"bits": 64},
}


def measure(scene: str, size: int, *, seconds: float, repeats: int, slowest: int) -> list[dict[str, Any]]:
    """Return a case for each backend, and for a session at either rate of calls.

    Args:
        seconds, repeats: the least to spend.
        slowest: numpy and double precision are left out of larger meshes.
    """
    gc.collect()  # what the case before left must not be counted as this one's
    before, started = memory_mb(), time.perf_counter()
    model, fingers, top = scene_of(scene, size)
    model_s, n = time.perf_counter() - started, len(model.mass)
    model_mb, substeps = memory_mb() - before, model.substeps(TICK)

    bodies: dict[str, tuple[Body, float, float]] = {}
    for name, options in KINDS.items():
        if n <= slowest or name == "native":
            before, started = memory_mb(), time.perf_counter()
            body: Body = native.Body(model, native.library(), **options)
            bodies[name] = body, time.perf_counter() - started, memory_mb() - before
    if n <= slowest or not bodies:
        bodies["numpy"] = Twin(model), 0.0, 0.0
    first = next(iter(bodies))
    ticks = PRESS_TICKS if fingers else 2
    bodies[first][0].step(Motion(ticks, substeps, TICK, tips(top, top - DEPTH, ticks, fingers)))
    pressed = bodies[first][0].positions(), bodies[first][0].velocities()
    for body, _, _ in bodies.values():
        body.set_state(*pressed)
    sessions = {call_ms: pressed_session(model, pressed, fingers, top) for call_ms in CALLS_MS if n <= SESSION_LIMIT}

    # a turn is what a session runs at once, or for numpy as many substeps as take a fraction of the time there is
    few = max(1, min(substeps, int(seconds / 2 / (n * 1e-6))))
    turns = {name: (1, few) if name == "numpy" else (TICKS_AT_ONCE, substeps) for name in bodies}
    times = {name: list[float]() for name in bodies}
    calls = {call_ms: list[float]() for call_ms in sessions}
    still = {ticks: tips(top - DEPTH, top - DEPTH, ticks, fingers) for ticks in (1, TICKS_AT_ONCE)}
    end = time.perf_counter() + seconds
    gc.disable()
    while time.perf_counter() < end or len(times[first]) < repeats:
        for name, (body, _, _) in reversed(bodies.items()):  # the first last, beside the sessions compared with it
            ticks, steps = turns[name]
            motion = Motion(ticks, steps, TICK * steps / substeps, still[ticks])
            stir(body)
            body.step(Motion(1, steps, TICK * steps / substeps, still[1]))  # untimed, as in `called`
            started = time.process_time()
            body.step(motion)
            times[name].append((time.process_time() - started) / (ticks * steps * n) * 1e9)
        for call_ms, session in sessions.items():
            stir(session.body)
            calls[call_ms].append(called(session, call_ms / 1e3))
    gc.enable()
    steps_alone = np.array(times[first]) * substeps * n * 1e-9
    return [
        {
            "scene": scene, "vertices": n, "backend": name, "call_ms": "", "substeps": substeps,
            "ns_per_vertex_step": round(float(np.median(times[name])), 3),
            "ns_least": round(min(times[name]), 3), "repeats": len(times[name]),
            "realtime_factor_1khz": round(TICK / (substeps * n * float(np.median(times[name])) * 1e-9), 4),
            "us_a_call_more": "", "times_the_steps": "",
            "set_up_s": round(model_s + extra_s, 4), "memory_mb": round(model_mb + extra_mb, 1),
        }
        for name, (_, extra_s, extra_mb) in bodies.items()
    ] + [
        session_case(scene, n, substeps, call_ms, np.array(calls[call_ms]), steps_alone) for call_ms in sessions
    ]  # fmt: skip


def stir(body: Body) -> None:
    """Wake a body: at rest, also under a still fingertip, it would cost nothing."""
    body.set_state(body.positions(), body.velocities())


def pressed_session(model: Model, pressed: tuple[Floats, Floats], fingers: int, top: float) -> Session:
    """Return a session whose body is pressed already, its fingertip where it is to stay."""
    session = Session(model)
    session.set_fingers([Finger((0.0, 0.0, top - DEPTH), FINGERTIP)] * fingers)
    session.body.set_state(*pressed)
    return session


def called(session: Session, call_s: float) -> float:
    """Return the processor time [s] of a second of calls over the time simulated: some calls, as a user makes them.

    In a viewport each call is looked at; a servo only wants the forces. Of two rounds the second counts: what ran
    before has left the caches full of something else, numpy most of all, while a session's calls follow each other.
    """
    count = max(1, round(TICKS_AT_ONCE * TICK / call_s))
    for _ in range(2):
        started, ticks = time.process_time(), 0
        for _ in range(count):
            session.set_fingers(session.fingers)
            ticks += session.step(call_s).steps
            if call_s > TICK:
                session.positions()
        spent = time.process_time() - started
    return spent / max(ticks, 1)


def session_case(
    scene: str, n: int, substeps: int, call_ms: float, ticks: Floats, steps_alone: Floats
) -> dict[str, Any]:
    """Return the times [s] of ticks through a session beyond those of their steps, repeat by repeat."""
    tick = float(np.median(ticks))
    return {
        "scene": scene, "vertices": n, "backend": "session", "call_ms": round(call_ms, 1), "substeps": substeps,
        "ns_per_vertex_step": round(tick / (substeps * n) * 1e9, 3),
        "ns_least": round(float(ticks.min()) / (substeps * n) * 1e9, 3), "repeats": len(ticks),
        "realtime_factor_1khz": round(TICK / tick, 4),
        "us_a_call_more": round(float(np.median(ticks - steps_alone)) * call_ms * 1e6, 1),
        "times_the_steps": round(float(np.median(ticks / steps_alone)), 3),
        "set_up_s": "", "memory_mb": "",
    }  # fmt: skip


def scene_of(scene: str, size: int) -> tuple[Model, int, float]:
    """Return its model, how many fingertips press, and where [m] their centres are when they touch."""
    make, material, pinned, fingers, _, more = SCENES[scene]
    mesh = make(size)
    model = build_model(mesh, [material], pinned=base_vertices(mesh) if pinned else None, **more)
    return model, fingers, float(mesh.rest_positions[:, 2].max()) + FINGERTIP


def tips(start: float, end: float, ticks: int, fingers: int) -> tuple[FingertipMotion, ...]:
    """Return fingertips going from one height [m] to another over the pole."""
    tip = straight((0.0, 0.0, start), (0.0, 0.0, end), ticks=ticks, radius=FINGERTIP)
    return (tip,) * fingers


def memory_mb() -> float:
    """Return the memory [MB] that this process holds; nan if the system does not report it."""
    statm = Path("/proc/self/statm")
    if not statm.exists():
        return float("nan")
    give_back = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if give_back:
        give_back(0)
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6


def bandwidth() -> float:
    """Return bytes a second that one core copies, read and written, well beyond its caches."""
    source, target = np.ones(2**24), np.zeros(2**24)
    best = float("inf")
    for _ in range(6):
        started = time.perf_counter()
        np.copyto(target, source)
        best = min(best, time.perf_counter() - started)
    return 2 * source.nbytes / best


def summary(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return, for each scene and backend, the log-log slope of cost, and how large a mesh keeps real time."""
    lines: dict[str, Any] = {}
    steps = [case for case in cases if case["backend"] != "session"]
    for scene, backend in sorted({(case["scene"], case["backend"]) for case in steps}):
        mine = [case for case in cases if (case["scene"], case["backend"]) == (scene, backend)]
        n = np.array([case["vertices"] for case in mine], float)
        cost = n * np.array([case["ns_per_vertex_step"] for case in mine]) * 1e-9
        tick = cost * [case["substeps"] for case in mine]
        line: dict[str, Any] = {}
        if len(mine) > 1:
            line["slope"] = round(float(np.polyfit(np.log(n), np.log(cost), 1)[0]), 3)
            line["largest_realtime"] = int(np.exp(np.interp(np.log(TICK), np.log(tick), np.log(n))))
            largest = np.interp(np.log(TICK / SUBSTEPS), np.log(cost), np.log(n))
            line[f"largest_realtime_{SUBSTEPS}_substeps"] = int(np.exp(largest))
        lines[f"{scene}, {backend}"] = line
    for case in cases:
        if case["backend"] == "session":
            named = f"{case['scene']}, {case['vertices']}, a call of {case['call_ms']} ms"
            more = {"us a call more": case["us_a_call_more"], "times the steps": case["times_the_steps"]}
            lines.setdefault("session", {})[named] = more
        if case["backend"] == "numpy":
            twin = next(c for c in cases if (c["scene"], c["vertices"], c["backend"]) == (*_place(case), "native"))
            ratio = case["ns_per_vertex_step"] / twin["ns_per_vertex_step"]
            lines.setdefault("numpy / native", {})[f"{case['scene']}, {case['vertices']}"] = round(ratio, 1)
    return lines


def _place(case: dict[str, Any]) -> tuple[str, int]:
    return case["scene"], case["vertices"]


def machine() -> str:
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.+)", info.read_text()) if info.exists() else None
    name = found[1] if found else platform.processor() or platform.machine()
    return re.sub(r"[^A-Za-z0-9]+", "-", f"{name} {os.cpu_count()} cores").strip("-")


def main(*, quick: bool) -> dict[str, Any]:
    """Measure every scene, print the table, keep it unless it was quick, and return the numbers."""
    print(f"{native.instructions()}; {machine()}; Python {platform.python_version()}, numpy {np.__version__}")
    print("scene      vertices backend         ns/vertex/step    least real time   set-up     MB")
    cases: list[dict[str, Any]] = []
    seconds, repeats, slowest = (0.4, 1, 12_000) if quick else (0.8, 2, 50_000)
    for scene, (*_, sizes, _more) in SCENES.items():
        for size in sizes:
            some = measure(scene, size, seconds=seconds, repeats=repeats, slowest=slowest)
            print("\n".join(map(row, some)), flush=True)
            cases += some
    lines, speed = summary(cases), bandwidth()
    for name, line in lines.items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in line.items()))
    if not quick:
        path = Path(__file__).parent / f"{machine()}.csv"
        with path.open("w", newline="") as file:
            table = csv.DictWriter(file, list(cases[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(cases)
        draw(cases, lines, speed, path.with_suffix(""))
        print(f"kept tests/bench/{path.name} and its chart")
    return {"instructions": native.instructions(), "bandwidth": speed, "cases": cases, "summary": lines}


def row(case: dict[str, Any]) -> str:
    name = f"{case['backend']} {case['call_ms']} ms" if case["call_ms"] else case["backend"]
    line = (
        f"{case['scene']:10} {case['vertices']:8} {name:15} {case['ns_per_vertex_step']:14.2f} "
        f"{case['ns_least']:8.2f} {case['realtime_factor_1khz']:8.2f}x "
    )
    if case["call_ms"]:
        return line + f"{case['us_a_call_more']:+.1f} us a call, {case['times_the_steps']:.2f} times the steps"
    return line + f"{case['set_up_s']:7.2f}s {case['memory_mb']:6.0f}"
