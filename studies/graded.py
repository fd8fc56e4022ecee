"""What proxies would gain that are fine near fingertips, or still far from them: error against cost, press by press.

A graded proxy (core.reduction.grading) is made for the place that a press goes to, or for all four places of a body at
once, as for a path that is known. An active region is a uniform proxy that is held beyond some radii from the press:
what is asleep costs nothing.
`python3 dev.py core graded --csv FILE`; `dev.py charts` draws it.

Found on six meshes of 4,058 vertices (tests/studies/charts/graded.csv): for the same error of the surface a proxy for
one press takes 0.07 to 0.32 of the work of a uniform one, for four places 0.26 to 0.52, and a region 0.10 to 1.57. The
planner takes a graded one only where no even proxy keeps the tolerances live: elsewhere the steps are no longer what a
frame takes, 5 to 6 ms of some 36 ms of a bake (40,000 vertices), and 1 of 7 to 9 ms of a live frame of a million.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from core.base import TICK, DimpleError, Floats
from core.body.model import Model
from core.native import create
from core.reduction.benchmark import BenchmarkPress, PressResult, choose_presses, outcome_of, press_body, press_variant
from core.reduction.grading import Pressed
from core.reduction.proxy import build_proxy
from core.steps import result_of

from . import bodies

CHOSEN = (3, 6, 9, 14, 18, 24)  # of bodies.FITTED
PRESSES, SEED = 4, 3
SIZES = {
    "uniform": (200, 283, 400, 566, 800, 1131), "graded": (100, 141, 200, 283, 400), "path": (141, 200, 283, 400, 566),
}  # fmt: skip
REGION, REACHES = 800, (2.0, 3.0, 4.5, 7.0)  # vertices of a uniform proxy; radii beyond which it stands still


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """A proxy and one press: its work, vertices x steps per tick, and its errors, over radius and as a share."""

    body: str
    press: int
    seeds: str  # "uniform", "region"; "graded" for this press, or "path" for the places of all presses of the body
    rung: int  # which of its kind
    vertices: int
    work: int
    error: float
    force_error: float


def rungs(chosen: Sequence[int] = CHOSEN, count: int = PRESSES) -> Iterator[Rung]:
    """Measure proxies of the chosen bodies.FITTED, by so many presses each."""
    for body in (bodies.FITTED[k] for k in chosen):
        model = bodies.build(body)
        presses = choose_presses(model, body.radius, count, seed=SEED)
        _, _, goals = result_of(press_variant(model, presses, 0))
        for k, (press, goal) in enumerate(zip(presses, goals, strict=True)):
            near = {"uniform": [], "graded": [press.at], "path": [each.at for each in presses]}
            for seeds, sizes in SIZES.items():
                for rung, size in enumerate(sizes):
                    if found := _measured(model, press, goal, size, near[seeds]):
                        yield Rung(body=body.name, press=k, seeds=seeds, rung=rung, **found)
            for rung, reach in enumerate(REACHES):
                if found := _measured(model, press, goal, REGION, [], reach):
                    yield Rung(body=body.name, press=k, seeds="region", rung=rung, **found)


def _measured(
    model: Model, press: BenchmarkPress, goal: PressResult, size: int, near: list[Floats], reach: float = np.inf
) -> dict[str, Any] | None:
    pressed = Pressed(tuple(tuple(at.tolist()) for at in near), press.radius) if near else None
    try:
        made = build_proxy(model, size, pressed)
    except DimpleError:
        return None
    moves, steps = made.model, made.model.substeps(TICK)
    still = np.linalg.norm(moves.mesh.rest_positions - press.at, axis=1) > reach * press.radius
    if still.any():  # what is asleep costs nothing: only the others are counted
        moves = replace(moves, pinned=moves.pinned | still, inverse_mass=np.where(still, 0.0, moves.inverse_mass))
    *_, (_, end) = press_body(create(moves), press, substeps=steps)
    found, vertices = outcome_of(model, size, made, steps, [end], [goal]), int((~still).sum())
    if not np.isfinite(found.error):
        return None
    return {
        "vertices": vertices, "work": vertices * steps, "error": found.error / press.radius,
        "force_error": found.force_error,
    }  # fmt: skip


def gains(found: list[Rung], what: str = "error") -> dict[str, dict[str, float]]:
    """Return, body by body, the median work of "graded" and "path" over that of uniform proxies of the same error.

    Args:
        what: "error" of the surface, or "force_error".
    """
    ratios: dict[str, dict[str, list[float]]] = {}
    for body, press in sorted({(rung.body, rung.press) for rung in found}):
        mine = [rung for rung in found if (rung.body, rung.press) == (body, press)]
        line = np.log([(r.work, getattr(r, what)) for r in mine if r.seeds == "uniform"])
        slope, start = np.polyfit(line[:, 0], line[:, 1], 1)
        for rung in mine:
            same = float(np.exp((np.log(getattr(rung, what)) - start) / slope))  # the work of a uniform one
            ratios.setdefault(body, {}).setdefault(rung.seeds, []).append(rung.work / same)
    return {body: {seeds: float(np.median(some)) for seeds, some in each.items()} for body, each in ratios.items()}


def add_graded(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--csv", type=Path, help="write every rung here")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what grading gains, and keep the rungs."""
    found = list(rungs())
    print("work over that of a uniform proxy with the same error, of the surface and of the force")
    forces = gains(found, "force_error")
    for body, gain in gains(found).items():
        each = (f"{seeds} {gain[seeds]:.2f} and {forces[body][seeds]:.2f}" for seeds in ("graded", "path", "region"))
        print(f"{body:26s} {', '.join(each)}", flush=True)
    if options.csv:
        write(options.csv, found)
    return 0


def write(path: Path, found: Sequence[Rung]) -> None:
    """Keep the rungs."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("body", "press", "seeds", "rung", "vertices", "work", "error_over_radius", "force_error"))
        writer.writerows((r.body, r.press, r.seeds, r.rung, r.vertices, r.work, f"{r.error:.4g}",
                          f"{r.force_error:.4g}") for r in found)  # fmt: skip
