"""What it saves to step only what moves of a large body, and what it costs in truth.

Heads of 0.4 to 1.7 m under fingertips of 10 and 20 mm, pressed by half a radius in 0.15 s and held for 0.1 s, in full
and with regions that rest. `python3 dev.py core regions`
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np

from core.base import TICK
from core.body.estimate import spread_on
from core.body.model import Model, build_model
from core.body.regions import divide
from core.material import PRESETS, Material
from core.mesh.surface import base_vertices
from core.reduction.active_regions import may_rest, share_awake, slack_of
from core.reduction.benchmark import DOWN, HOLD, BenchmarkPress, PressResult, choose_presses, outcome_of, press_body
from core.reduction.decision import TOLERANCE
from core.solver.backend import create
from core.solver.motion import Frame, Motion

from . import bodies

VINYL = PRESETS[1].material
# squares along a side, size [m], material, fingertip [m]
CASES: tuple[tuple[int, float, Material, float], ...] = (
    (160, 0.2, VINYL, 0.004), (160, 0.4, replace(bodies.FOAM, spread=0.008), 0.01), (80, 0.6, VINYL, 0.01),
    (120, 0.6, bodies.FOAM, 0.01), (120, 1.0, VINYL, 0.01), (120, 1.7, VINYL, 0.02),
)  # fmt: skip
SEED = 3


@dataclass(slots=True)
class Counted:
    """A body whose stepped vertices are counted; see `solver.backend.Body`."""

    body: object
    stepped: list[int]

    def positions(self) -> np.ndarray:
        return self.body.positions()  # type: ignore[attr-defined]

    def step(self, motion: Motion) -> Frame:
        frame: Frame = self.body.step(motion)  # type: ignore[attr-defined]
        self.stepped.append(frame.stepped)
        return frame


def pressed(model: Model, press: BenchmarkPress, slack: float) -> tuple[PressResult, float]:
    """Return the end of a press, and the share of the vertices that was stepped in the mean."""
    body = Counted(create(model, regions=divide(model, slack) if slack else None), [])
    *_, (_, end) = press_body(body, press, substeps=model.substeps(TICK))  # type: ignore[arg-type]
    return end, float(np.mean(body.stepped)) / len(model.mass)


def add_regions(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--presses", type=int, default=3)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print processor time of a simulated second, in full and with regions, the share that is stepped, and errors."""
    for fine, size, material, radius in CASES:
        mesh = bodies.head(fine, size)
        model = build_model(mesh, [material], pinned=base_vertices(mesh))
        steps, slack = model.substeps(TICK), slack_of(TOLERANCE, radius)
        assert may_rest(model)
        goals, ends, shares = [], [], []
        for press in choose_presses(model, radius, options.presses, seed=SEED):
            goals.append(pressed(model, press, 0.0)[0])
            end, share = pressed(model, press, slack)
            ends.append(end)
            shares.append(share)
        whole, part = (np.median([end.cost for end in each]) / (DOWN + HOLD) for each in (goals, ends))
        off = outcome_of(model, 0, None, steps, ends, goals)
        print(
            f"{len(model.mass):,} vertices, {size:g} m, {material.fill}, spread "
            f"{1e3 * spread_on(material, size):.3g} mm, tip {1e3 * radius:g} mm, {steps} steps: {whole:.3g} s a second "
            f"in full, {part:.3g} s with regions ({part / whole:.3f}); {np.mean(shares):.1%} stepped, "
            f"{share_awake(model, radius, slack):.1%} expected; "
            f"force {off.force_error:.2%} off, surface {1e6 * off.error:.1f} um", flush=True,
        )  # fmt: skip
    return 0
