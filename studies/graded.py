"""What a proxy would gain that is fine near one fingertip and coarse elsewhere: error against cost, press by press.

Each press has a graded proxy of its own, made for the place that it goes to: the spacing is the least within 1.5
fingertip radii, and grows to FAR times as much 3 radii on. `python3 dev.py core graded --csv FILE`.

Found (tests/studies/charts/graded.csv): on meshes of 4,058 vertices a quarter of a uniform proxy's work for the same
error of the surface, where it is known beforehand what is pressed. A live fingertip that goes elsewhere would need
another proxy, and the motion carried over to it, at once.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import numpy as np

from core.base import TICK, DimpleError, Floats, Ints
from core.body.model import Model
from core.mesh.surface import Mesh
from core.reduction import proxy as proxies
from core.reduction.benchmark import BenchmarkPress, PressResult, choose_presses, outcome_of, press_body, press_variant
from core.reduction.cells import spread_seeds
from core.solver.backend import create
from core.steps import result_of

from . import bodies

CHOSEN = (3, 6, 9, 14, 18, 24)  # of bodies.FITTED
PRESSES, SEED = 4, 3
FAR = 3.0  # spacings: how coarse the far side is
UNIFORM, GRADED = (200, 283, 400, 566, 800, 1131), (100, 141, 200, 283, 400)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """A proxy and one press: its work, vertices x steps per tick, and its errors, over radius and as a share."""

    body: str
    press: int
    seeds: str
    vertices: int
    work: int
    error: float
    force_error: float


def graded_seeds(mesh: Mesh, place: Floats, used: Ints, count: int, at: Floats, radius: float) -> Ints:
    """Choose seeds farthest first, distances over the spacing that is wanted where they end."""
    away = np.linalg.norm(mesh.rest_positions[used] - at, axis=1)
    wanted = np.clip(1 + (FAR - 1) * (away - 1.5 * radius) / (3 * radius), 1, FAR)
    points, chosen = place[used], [int(away.argmin())]
    near = np.full(len(used), np.inf)
    for _ in range(count - 1):
        near = np.minimum(near, ((points - points[chosen[-1]]) ** 2).sum(axis=1) / wanted**2)
        chosen.append(int(near.argmax()))
    return used[np.array(chosen)]


def rungs() -> Iterator[Rung]:
    """Measure uniform and graded proxies of CHOSEN bodies, press by press."""
    for body in (bodies.FITTED[k] for k in CHOSEN):
        model = bodies.build(body)
        presses = choose_presses(model, body.radius, PRESSES, seed=SEED)
        _, _, goals = result_of(press_variant(model, presses, 0))
        for k, (press, goal) in enumerate(zip(presses, goals, strict=True)):
            for seeds, sizes in (("uniform", UNIFORM), ("graded", GRADED)):
                for size in sizes:
                    found = _measured(model, press, goal, size, graded=seeds == "graded")
                    if found:
                        yield Rung(body=body.name, press=k, seeds=seeds, vertices=found[0], work=found[1],
                                   error=found[2], force_error=found[3])  # fmt: skip


def _measured(
    model: Model, press: BenchmarkPress, goal: PressResult, size: int, *, graded: bool
) -> tuple[int, int, float, float] | None:
    def seeds(mesh: Mesh, place: Floats, used: Ints, count: int, spacing: float) -> Ints:
        if not graded:
            return spread_seeds(mesh, place, used, count, spacing)
        return graded_seeds(mesh, place, used, count, press.at, press.radius)

    try:
        with patch.object(proxies, "spread_seeds", seeds):
            made = proxies.build_proxy(model, size)
    except DimpleError:
        return None
    steps = made.model.substeps(TICK)
    *_, (_, end) = press_body(create(made.model), press, substeps=steps)
    found = outcome_of(model, size, made, steps, [end], [goal])
    return found.vertices, found.vertices * steps, found.error / press.radius, found.force_error


def gains(found: list[Rung]) -> dict[str, float]:
    """Return, body by body, the median work of graded proxies over that of uniform ones of the same surface error."""
    ratios: dict[str, list[float]] = {}
    for body, press in sorted({(rung.body, rung.press) for rung in found}):
        mine = [rung for rung in found if (rung.body, rung.press) == (body, press)]
        line = np.log([(r.work, r.error) for r in mine if r.seeds == "uniform"])
        slope, start = np.polyfit(line[:, 0], line[:, 1], 1)
        ratios.setdefault(body, []).extend(
            rung.work / float(np.exp((np.log(rung.error) - start) / slope)) for rung in mine if rung.seeds == "graded"
        )
    return {body: float(np.median(some)) for body, some in ratios.items()}


def add_graded(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--csv", type=Path, help="write every rung here")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what grading gains, and keep the rungs."""
    found = list(rungs())
    for body, gain in gains(found).items():
        print(f"{body:26s} work over that of a uniform proxy with the same surface error: {gain:.2f}", flush=True)
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(("body", "press", "seeds", "vertices", "work", "error_over_radius", "force_error"))
            writer.writerows((r.body, r.press, r.seeds, r.vertices, r.work, f"{r.error:.4g}", f"{r.force_error:.4g}")
                             for r in found)  # fmt: skip
    return 0
