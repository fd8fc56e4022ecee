"""Would a quasi-static mode pay for slow presses? What each frame takes: stiffness products, against dynamic steps.

A frame of an equilibrium takes conjugate-gradient iterations, each a product with the stiffness and a preconditioning;
natively one costs about as much as a step does (9 against 10 ns a vertex). A frame of the dynamic
body takes its steps, however slow the press is. `python3 dev.py core quasi-static --csv FILE`.

Found (tests/studies/charts/quasi_static.csv): a frame of a sixtieth of a second takes 1.7 to 6.9 times as many products
as steps, so the mode does not pay live. It would pay for single poses far apart.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from core.base import TICK, Floats
from core.reduction.benchmark import choose_presses
from core.reduction.proxy import build_proxy

from . import bodies
from .graded import CHOSEN
from .methods import newton
from .methods.equilibrium import equilibrium, spheres
from .methods.tangent import Tangent, tangent

VERTICES = 141, 400  # of proxies
FRAMES, FRAME = 6, 1 / 60  # [s]
TOLERANCE = 0.01  # unbalanced force over that of the fingertip


@dataclass(frozen=True, slots=True, kw_only=True)
class Frames:
    """What the frames of a press take: products each, the dynamic steps of one, and how many reached equilibrium."""

    body: str
    vertices: int
    products: tuple[int, ...]
    steps: int
    converged: int


def press_slowly(body: bodies.BodyCase, vertices: int) -> Frames:
    """Press a proxy to half the fingertip's radius frame by frame, each from the equilibrium before."""
    full = bodies.build(body)
    model = build_proxy(full, vertices).model
    press = choose_presses(full, body.radius, 1, seed=2)[0]
    counted, products, converged = [0], [], 0
    x: Floats | None = None
    def counting(*given: Any) -> Tangent:
        system = tangent(*given)

        def product(s: Floats) -> Floats:
            counted[0] += 1
            return system.product(s)

        return replace(system, product=product)

    with patch.object(newton, "tangent", counting):
        for frame in range(1, FRAMES + 1):
            centre = press.at + press.outward * (press.radius - press.depth * frame / FRAMES)
            before = counted[0]
            rest = equilibrium(model, spheres(model, centre, np.array([press.radius])), start=x, tolerance=TOLERANCE)
            products.append(counted[0] - before)
            x, converged = rest.positions, converged + rest.converged
    steps = round(FRAME / TICK * model.substeps(TICK))
    return Frames(
        body=body.name, vertices=len(model.mass), products=tuple(products), steps=steps, converged=converged
    )  # fmt: skip


def add_quasi_static(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--csv", type=Path, help="write the table here")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what a frame takes either way, and keep it."""
    found = []
    for body in (bodies.FITTED[k] for k in CHOSEN):
        for vertices in VERTICES:
            found.append(press_slowly(body, vertices))
            each = found[-1]
            print(
                f"{each.body:24s} {each.vertices:5d} vertices: {np.median(each.products):6.0f} products a frame, "
                f"{each.steps} steps; {each.converged} of {FRAMES} frames at equilibrium", flush=True,
            )  # fmt: skip
    if options.csv:
        write(options.csv, found)
    return 0


def write(path: Path, found: Sequence[Frames]) -> None:
    """Keep the table."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("body", "vertices", "products_a_frame", "steps_a_frame", "converged", "frames"))
        writer.writerows((e.body, e.vertices, np.median(e.products), e.steps, e.converged, FRAMES) for e in found)
