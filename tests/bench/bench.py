"""Measure a step: scenes x sizes x backends, in one run. `python3 dev.py bench [--quick] [--json FILE]`

A timing here is processor time of one core, the median over repeats that go round the backends in turn, so that a
busy machine slows them alike; the least is beside it. Ratios within a run are what to compare. The full run keeps a
CSV and a chart per machine.
"""

from __future__ import annotations

import argparse
import csv
import ctypes
import gc
import json
import os
import platform
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from core import native
from core.body.model import Model, State, build_model, initial_state
from core.material import PRESETS, Material
from core.mesh.surface import Mesh, base_vertices
from core.session import TICKS_AT_ONCE
from core.solver import semi_implicit
from core.solver.path import FingerPath
from studies.scenes import BALL, BALL_RADIUS, FINGERTIP, ball, cube
from tests.bench.chart import draw

Stepper = Callable[[Model, State, FingerPath, float, int], object]

TICK = 1e-3  # [s]
DEPTH = 0.010  # [m] of the press that is measured
PRESS_TICKS = 8  # from the skin to there
BALL_SIZES, CUBE_SIZES = (3, 4, 5, 6, 7), (10, 20, 41, 82, 165)  # 642 or 602 vertices to 164 thousand
SUBSTEPS = 10  # in a tick, for "so many vertices in real time"

WORLD = {"bend": 0.1, "gravity": (0.0, 0.0, -9.81), "ground": -BALL_RADIUS}

# scene: mesh of a size, material, held by its base, number of fingertips, sizes, and what build_model is told beside
SCENES: dict[str, tuple[Callable[[int], Mesh], Material, bool, int, tuple[int, ...], dict[str, Any]]] = {
    "poke_ball": (ball, BALL, True, 1, BALL_SIZES, {}),
    "free_ball": (ball, BALL, False, 0, BALL_SIZES, {}),
    "poke_cube": (lambda cells: cube(cells, PRESETS[2].size), PRESETS[2].material, True, 1, CUBE_SIZES, {}),
    "everything": (ball, BALL, False, 1, BALL_SIZES, WORLD),
}


def measure(scene: str, size: int, *, seconds: float, repeats: int, slowest: int) -> list[dict[str, Any]]:
    """Return a case for each backend.

    Args:
        seconds, repeats: the least to spend.
        slowest: numpy and double precision are left out of larger meshes.
    """
    gc.collect()  # what the case before left must not be counted as this one's
    before, started = memory_mb(), time.perf_counter()
    model, fingers, top = scene_of(scene, size)
    model_s, n = time.perf_counter() - started, len(model.mass)
    model_mb, substeps = memory_mb() - before, model.substeps(TICK)

    bodies: dict[str, tuple[Stepper, float, float]] = {}
    kinds = {"native": (32, native.BEST)}
    if n <= slowest:
        kinds |= {"native, no AVX": (32, native.BASE), "native64": (64, native.BEST)}
    for name, (bits, instruction_set) in kinds.items() if not native.why_not() else ():
        before, started = memory_mb(), time.perf_counter()
        body = native.Body(native.library(), model, bits, instruction_set)
        bodies[name] = with_native(body), time.perf_counter() - started, memory_mb() - before
    if n <= slowest or not bodies:
        bodies["numpy"] = with_numpy, 0.0, 0.0

    states = {name: initial_state(model) for name in bodies}
    first, state = next(iter(bodies)), states[next(iter(bodies))]
    bodies[first][0](model, state, straight(top, top - DEPTH, PRESS_TICKS if fingers else 2, fingers), TICK, substeps)
    for name in states:
        states[name].positions, states[name].velocities = state.positions.copy(), state.velocities.copy()
        states[name].pressure = state.pressure

    # a turn is what a session runs at once, or for numpy as many substeps as take a fraction of the time there is
    few = max(1, min(substeps, int(seconds / 2 / (n * 1e-6))))
    turns = {name: (1, few) if name == "numpy" else (TICKS_AT_ONCE, substeps) for name in bodies}
    times = {name: list[float]() for name in bodies}
    end = time.perf_counter() + seconds
    gc.disable()
    while time.perf_counter() < end or len(times[first]) < repeats:
        for name, (stepper, _, _) in bodies.items():
            ticks, steps = turns[name]
            still = straight(top - DEPTH, top - DEPTH, ticks, fingers)
            started = time.process_time()
            stepper(model, states[name], still, TICK * steps / substeps, steps)
            times[name].append((time.process_time() - started) / (ticks * steps * n) * 1e9)
    gc.enable()
    return [
        {
            "scene": scene, "vertices": n, "backend": name, "substeps": substeps,
            "ns_per_vertex_step": round(float(np.median(times[name])), 3),
            "ns_least": round(min(times[name]), 3), "repeats": len(times[name]),
            "realtime_factor_1khz": round(TICK / (substeps * n * float(np.median(times[name])) * 1e-9), 4),
            "set_up_s": round(model_s + extra_s, 4), "memory_mb": round(model_mb + extra_mb, 1),
        }
        for name, (_, extra_s, extra_mb) in bodies.items()
    ]  # fmt: skip


def scene_of(scene: str, size: int) -> tuple[Model, int, float]:
    """Return its model, how many fingertips press, and where [m] their centres are when they touch."""
    make, material, held, fingers, _, more = SCENES[scene]
    mesh = make(size)
    model = build_model(mesh, [material], held=base_vertices(mesh) if held else None, **more)
    return model, fingers, float(mesh.rest_positions[:, 2].max()) + FINGERTIP


def with_native(body: native.Body) -> Stepper:
    return lambda model, state, path, tick, steps: native.run_body(body, model, state, path, tick=tick, substeps=steps)


def with_numpy(model: Model, state: State, path: FingerPath, tick: float, steps: int) -> object:
    return semi_implicit.run(model, state, path, tick=tick, substeps=steps)


def straight(start: float, end: float, ticks: int, fingers: int) -> FingerPath:
    """Return fingertips going from one height [m] to another over the pole."""
    centres = np.zeros((fingers, ticks + 1, 3))
    centres[:, :, 2] = np.linspace(start, end, ticks + 1)
    return FingerPath(centres=centres, radii=np.full(fingers, FINGERTIP))


def memory_mb() -> float:
    """Return what this process holds, less what it has freed; nan where the system does not tell."""
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
    for scene, backend in sorted({(case["scene"], case["backend"]) for case in cases}):
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


def main(words: list[str]) -> int:
    summary_line = (__doc__ or "").partition("\n")[0]
    parser = argparse.ArgumentParser(prog="dev.py bench", description=summary_line, allow_abbrev=False)
    quick = "under 50 seconds: few repeats, slow backends to 10,000 vertices only"
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the numbers go")
    parser.add_argument("--profile", action="store_true", help="what each part of a step costs, instead")
    parser.add_argument("--peers", action="store_true", help="Dimple beside Bullet on the same bodies, instead")
    parser.add_argument("--enabling", action="store_true", help="what enabling costs in Blender, instead")
    options = parser.parse_args(words)
    if options.enabling:
        from tests.bench import enabling

        return enabling.main()
    if options.peers:
        from tests.bench import peers

        rows = peers.measure_all()
        if options.json:
            options.json.write_text(json.dumps({"machine": machine(), "cases": rows}, indent=1) + "\n")
        return 0
    if options.profile:
        from tests.bench import profile

        return profile.main()
    note = native.why_not()
    print(f"{note or native.instructions()}; {machine()}; Python {platform.python_version()}, numpy {np.__version__}")
    print("scene      vertices backend         ns/vertex/step    least real time   set-up     MB")
    cases: list[dict[str, Any]] = []
    seconds, repeats, slowest = (0.4, 1, 12_000) if options.quick else (0.8, 2, 50_000)
    for scene, (*_, sizes, _more) in SCENES.items():
        for size in sizes:
            some = measure(scene, size, seconds=seconds, repeats=repeats, slowest=slowest)
            print("\n".join(map(row, some)), flush=True)
            cases += some
    lines, speed = summary(cases), bandwidth()
    for name, line in lines.items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in line.items()))
    if options.json:
        whole = {"machine": machine(), "instructions": note or native.instructions(), "bandwidth": speed}
        options.json.write_text(json.dumps(whole | {"cases": cases, "summary": lines}, indent=1) + "\n")
    if not options.quick:
        path = Path(__file__).parent / f"{machine()}.csv"
        with path.open("w", newline="") as file:
            table = csv.DictWriter(file, list(cases[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(cases)
        draw(cases, lines, speed, path.with_suffix(""))
        print(f"kept tests/bench/{path.name} and its chart")
    return 0


def row(case: dict[str, Any]) -> str:
    return (
        f"{case['scene']:10} {case['vertices']:8} {case['backend']:15} {case['ns_per_vertex_step']:14.2f} "
        f"{case['ns_least']:8.2f} {case['realtime_factor_1khz']:8.2f}x {case['set_up_s']:7.2f}s "
        f"{case['memory_mb']:6.0f}"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
