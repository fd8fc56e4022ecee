"""Measure each part of a step: `python3 dev.py bench --profile`."""

from __future__ import annotations

import ctypes
import sys
import time

import numpy as np

from core import native
from core.native.motion import Motion
from core.session.clock import TICKS_AT_ONCE
from tests.bench import bench
from tools.native import compile_library, this_platform

PARTS = ("fits", "rings", "irregular and fill", "advance", "contact", "reach")  # core/native/profile.h
SIZES = {"poke_ball": (3, 4, 5, 7), "free_ball": (3, 4, 5, 7), "poke_cube": (10, 20, 41, 165), "everything": (4, 5)}
TIMES = 60  # calls of the stepper, a third for the largest bodies; the median of the quickest quarter counts


def measured(library: ctypes.CDLL, scene: str, size: int) -> tuple[int, list[float]]:
    """Return the number of vertices and [ns per vertex and step] of each part and of the whole."""
    model, fingers, top = bench.scene_of(scene, size)
    n, substeps = len(model.mass), model.substeps(bench.TICK)
    body = native.Body(model, library)
    kind = {"SSE2": "base", "NEON": "base", "AVX2": "avx2"}[library.dm_instructions(native.BEST).decode()]
    spent = np.ctypeslib.as_array((ctypes.c_double * len(PARTS)).in_dll(library, f"dm_seconds_{kind}_32"))
    down = bench.straight(top, top - bench.DEPTH, bench.PRESS_TICKS, fingers)
    body.step(Motion(bench.PRESS_TICKS, substeps, bench.TICK, down))
    ticks = max(1, min(TICKS_AT_ONCE, int(2e6 / (n * substeps))))
    still, rows = bench.straight(top - bench.DEPTH, top - bench.DEPTH, ticks, fingers), []
    for _ in range(TIMES if n < 100_000 else TIMES // 3):
        bench.stir(body)
        body.step(Motion(1, substeps, bench.TICK, bench.straight(top - bench.DEPTH, top - bench.DEPTH, 1, fingers)))
        before, started = spent.copy(), time.perf_counter()
        body.step(Motion(ticks, substeps, bench.TICK, still))
        rows.append([time.perf_counter() - started, *(spent - before)])
    whole, *parts = np.median(sorted(rows)[: len(rows) // 4], axis=0) / (ticks * substeps * n) * 1e9
    return n, [*map(float, parts), float(whole)]


def main() -> int:
    name = this_platform()
    library = native.load(compile_library(sys.executable, name, "-DDM_PROFILE"))
    print(f"{native.instructions()}, f32; ns per vertex and step of {bench.machine()}")
    print("| scene | vertices | " + " | ".join(PARTS) + " | the rest | whole |")
    print("|---|---" + "|---" * (len(PARTS) + 2) + "|")
    for scene, sizes in SIZES.items():
        for size in sizes:
            n, costs = measured(library, scene, size)
            cells = [*costs[:-1], costs[-1] - sum(costs[:-1]), costs[-1]]
            print(f"| {scene} | {n} | " + " | ".join(f"{cost:.2f}" for cost in cells) + " |", flush=True)
    return 0
