"""What a body loses that is simulated k times faster than its slow fingertips go (core.reduction.slow_press).

On six bodies a fingertip goes in by half its radius at a speed, stays for half a second and comes out again, all at an
even speed: it starts and stops at once, which is the worst. Force and surface, look by look, against the same press
with k = 1. `python3 dev.py core slow-presses --csv FILE`.

Found (tests/studies/charts/slow_presses.csv): where the bound is 5 % or less the force is within 0.54 % in the mean and
7.3 % at the worst look, the surface within 0.03 mm, and 0.004 mm are left half a second after the press.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields, replace
from pathlib import Path

import numpy as np

from core.base import TICK, Floats
from core.body.model import Model
from core.reduction.benchmark import BenchmarkPress, choose_presses, dent_error
from core.reduction.slow_press import answer_time
from core.session import Finger, Session

from . import bodies
from .graded import CHOSEN

SPEEDS, FASTER = (2e-3, 5e-3, 10e-3), (2, 4, 8)  # [m/s]
LOOK, REST = 1 / 120, 0.5  # [s] between two looks, and in and after the press
CLEAR = 0.5e-3  # [m] the fingertip starts above the surface
SEEN = 12  # looks from one surface that is compared to the next


@dataclass(frozen=True, slots=True, kw_only=True)
class Loss:
    """What is lost by k = faster.

    bound: of the force, the share v k tau / depth.
    force, mean_force: largest and root-mean-square difference over the largest force.
    surface: largest root-mean-square difference over the dent [mm].
    left: of the surface half a second after the press, over all [mm].
    steps: over those of k = 1.
    """

    body: str
    damping: float
    speed: float
    faster: int
    bound: float
    force: float
    mean_force: float
    surface: float
    left: float
    steps: float


@dataclass(frozen=True, slots=True)
class Pressed:
    forces: Floats
    surfaces: list[Floats]
    steps: int


def press_slowly(model: Model, press: BenchmarkPress, speed: float, faster: int) -> Pressed:
    """Press a full mesh, looking at it every 1/120 s."""
    down = (press.depth + CLEAR) / speed
    session, forces, surfaces = Session(model), [], []
    session.set_clock(LOOK / math.ceil(LOOK / TICK / faster), faster=faster, slow=1.01 * speed)
    for look in range(math.ceil((2 * down + 2 * REST) / LOOK)):
        time = look * LOOK
        depth = speed * min(time, down, max(2 * down + REST - time, 0.0)) - CLEAR
        session.set_fingers([Finger(tuple(press.at + press.outward * (press.radius - depth)), press.radius)])
        frame = session.step(LOOK if look else 0.0)
        forces.append(float(frame.finger_forces[0] @ press.outward))
        if look % SEEN == 0:
            surfaces.append(session.skin().copy())
    return Pressed(np.array(forces), surfaces, session.frame.total_steps)


def losses(case: bodies.BodyCase, *, damping: float | None = None, gravity: float = 0.0) -> Iterator[Loss]:
    """Measure one body, with another damping ratio if one is given."""
    material = case.material if damping is None else replace(case.material, damping_ratio=damping)
    model = bodies.build(replace(case, material=material))
    if gravity:
        model = replace(model, gravity=np.array((0.0, 0.0, -gravity)))
    (press,) = choose_presses(model, case.radius, 1, seed=3)
    tau = answer_time(model, press.depth)
    for speed in SPEEDS:
        goal = press_slowly(model, press, speed, 1)
        top = goal.forces.max()
        for faster in FASTER:
            found = press_slowly(model, press, speed, faster)
            off = np.abs(found.forces - goal.forces) / top
            pairs, still = [*zip(found.surfaces, goal.surfaces, strict=True)], model.mesh.rest_positions
            dented = [dent_error(model.mesh, a, b) for a, b in pairs if np.abs(b - still).max() > CLEAR]
            yield Loss(
                body=case.name, damping=material.damping_ratio, speed=speed, faster=faster,
                bound=speed * faster * tau / press.depth, force=float(off.max()),
                mean_force=float(np.sqrt((off**2).mean())), surface=1e3 * max(dented),
                left=1e3 * float(np.abs(pairs[-1][0] - pairs[-1][1]).max()), steps=found.steps / goal.steps,
            )  # fmt: skip


def add_slow_presses(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--csv", type=Path, help="write the table here")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what is lost, and keep it."""
    found = []
    for case in (bodies.FITTED[k] for k in CHOSEN):
        for each in losses(case):
            found.append(each)
            print(
                f"{each.body:24s} {1e3 * each.speed:3.0f} mm/s, k = {each.faster}: force {each.force:6.1%} at worst of "
                f"a bound of {each.bound:6.1%}, {each.mean_force:6.2%} in the mean; surface {each.surface:.3f} mm, "
                f"{each.left:.4f} mm left; steps x {each.steps:.2f}", flush=True,
            )  # fmt: skip
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow([field.name for field in fields(Loss)])
            writer.writerows([f"{v:.4g}" if isinstance(v, float) else v for v in astuple(each)] for each in found)
    return 0
