"""Measure the cost of the tension of shape matching: `python3 dev.py bench --tension`.

The same pinned bodies, in turn, by the library and by one whose ring pass is compiled without the tension. They have no
spread, so that both do the same; what a tension multiplies by does not change what it costs.
"""

from __future__ import annotations

import ctypes
import sys
import time
from dataclasses import replace

import numpy as np

from core import native
from core.base import Floats
from core.body.model import build_model
from core.mesh.surface import base_vertices
from core.native.motion import Motion
from core.session.clock import TICKS_AT_ONCE
from tests.bench import bench
from tools.native import compile_library, this_platform

SIZES = {"poke_ball": (4, 5), "poke_cube": (20, 41)}  # 2,500 and 10,000 vertices
TURNS = 60


def ratios(scene: str, size: int, libraries: list[ctypes.CDLL]) -> tuple[int, list[float], Floats]:
    """Return the number of vertices, medians [ns per vertex and step], and the ratio of each turn."""
    make, material, pinned, fingers, _, more = bench.SCENES[scene]
    mesh = make(size)
    material = replace(material, spread=0.0)
    model = build_model(mesh, [material], pinned=base_vertices(mesh) if pinned else None, **more)
    n, substeps, top = len(model.mass), model.substeps(bench.TICK), bench.scene_of(scene, size)[2]
    bodies = [native.Body(model, library) for library in libraries]
    for body in bodies:
        down = bench.straight(top, top - bench.DEPTH, bench.PRESS_TICKS, fingers)
        body.step(Motion(bench.PRESS_TICKS, substeps, bench.TICK, down))
    ticks = max(1, min(TICKS_AT_ONCE, int(1e6 / (n * substeps))))
    still = bench.straight(top - bench.DEPTH, top - bench.DEPTH, ticks, fingers)
    times = np.zeros((TURNS, 2))
    for turn in range(TURNS):
        for i in (0, 1) if turn % 2 else (1, 0):
            started = time.process_time()
            bodies[i].step(Motion(ticks, substeps, bench.TICK, still))
            times[turn, i] = (time.process_time() - started) / (ticks * substeps * n) * 1e9
    assert np.array_equal(bodies[0].positions(), bodies[1].positions()), "they do not do the same"
    return n, np.median(times, axis=0).tolist(), times[:, 0] / times[:, 1]


def main() -> int:
    name = this_platform()
    libraries = [native.library(), native.load(compile_library(sys.executable, name, "-DDM_NO_TENSION"))]
    print(f"{native.instructions()}, f32, {bench.machine()}; ns per vertex and step with tension, without, their ratio")
    for scene, sizes in SIZES.items():
        for size in sizes:
            n, (beside, without), each = ratios(scene, size, libraries)
            low, high = np.percentile(each, [25, 75])
            print(
                f"{scene:10} {n:7,} vertices  {beside:6.2f} {without:6.2f}  "
                f"{np.median(each):.3f} (half of the turns {low:.3f} to {high:.3f})", flush=True,
            )
    return 0
