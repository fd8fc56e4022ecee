"""What a fingertip that is small beside a fine body gains by a proxy that is fine where it presses.

A head of 200 mm and 153,602 vertices is pressed by half the radius: by the full mesh, by 8,000 vertices spread evenly,
and by what the planner makes for the one press, and for all of them. `python3 dev.py core small-tips [--presses 6]`
"""

from __future__ import annotations

import argparse

import numpy as np

from core.base import TICK
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.native import create
from core.reduction.benchmark import DOWN, HOLD, BenchmarkPress, PressResult, choose_presses, outcome_of, press_body
from core.reduction.grading import pressed_by
from core.reduction.planner import plan, plan_proxy
from core.reduction.proxy import LARGEST

from . import bodies

FINE, SIZE = 160, 0.2  # squares along a side of the head, [m]
RADII = 0.004, 0.003  # [m]
SEED = 3


def add_small_tips(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--presses", type=int, default=6)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print vertices, steps, processor time of a simulated second and the largest errors, each way."""
    mesh = bodies.head(FINE, SIZE)
    model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
    for radius in RADII:
        presses = choose_presses(model, radius, options.presses, seed=SEED)
        goals = [pressed(model, press) for press in presses]
        cost = np.median([goal.cost for goal in goals]) / (DOWN + HOLD)
        print(f"{1e3 * radius:g} mm: full mesh of {len(model.mass):,} vertices, {cost:.3g} s", flush=True)
        aways = [4 * radius, radius - presses[0].depth]
        ways = [np.array([each.at + each.outward * away for away in aways]) for each in presses]
        even = plan_proxy(model, LARGEST, radius=radius)
        near_all = plan(model, radius=radius, pressed=pressed_by(mesh, ways, radius))
        near_one = [plan(model, radius=radius, pressed=pressed_by(mesh, [way], radius)) for way in ways]
        many = len(presses)
        for name, chosen in (("even", [even] * many), ("near the one", near_one), ("near all", [near_all] * many)):
            found = []
            for each, press, goal in zip(chosen, presses, goals, strict=True):
                end = pressed(each.proxy.model if each.proxy else model, press)
                outcome = outcome_of(model, each.asked, each.proxy, each.steps, [end], [goal])
                found.append((outcome.vertices, each.steps, outcome.cost, outcome.force_error, outcome.error / radius))
            (vertices, steps, cost, *_), (*_, force, surface) = np.median(found, axis=0), np.max(found, axis=0)
            print(
                f"  {name}: {vertices:,.0f} vertices, {steps:.0f} steps, {cost:.2g} s, {force:.1%} of the force, "
                f"{surface:.3f} radii", flush=True,
            )  # fmt: skip
    return 0


def pressed(model: Model, press: BenchmarkPress) -> PressResult:
    """Return the end of a press of a model."""
    *_, (_, end) = press_body(create(model), press, substeps=model.substeps(TICK))
    return end
