"""The methods, as data: what each is for, where it fails, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from core.base import Floats
from core.body.model import Model
from studies.reference.laws import State

from ..reference import semi_implicit
from ..reference.path import FingerPath
from . import (
    backward_euler,
    explicit_euler,
    implicit_midpoint,
    rk4,
    tr_bdf2,
    velocity_verlet,
    vertex_block_descent,
    xpbd,
)


class Run(Protocol):
    """Advance a state in place along a path and return the impulses (k, 3) [N s] on the fingertips."""

    def __call__(self, model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """A time-stepping method.

    label: what charts call it.
    run: the method itself.
    order: of convergence in the time step.
    kind: "explicit", "implicit" (solved to a tolerance) or "sweeping" (law by law or vertex by vertex, a fixed number
        of times).
    purpose: what it is for.
    fails: where it fails, and why.
    """

    label: str
    run: Run
    order: int
    kind: str
    purpose: str
    fails: str


METHODS = {
    "explicit_euler": Method(
        label="explicit Euler", run=explicit_euler.run, order=1, kind="explicit",
        purpose="to show why the order of the two updates matters",
        fails="Without damping it diverges at every step: each one multiplies the energy of a mode by "
        "1 + (omega dt)^2. With damping z it needs dt < 2 z / omega.",
    ),
    "semi_implicit": Method(
        label="semi-implicit Euler", run=semi_implicit.run, order=1, kind="explicit",
        purpose="the paper's; live work on most bodies",
        fails="Beyond dt = 2 / omega (less with damping) the stiffest edge flips over each step and grows. "
        "It is of first order, and damping acts a step late.",
    ),
    "velocity_verlet": Method(
        label="velocity Verlet", run=velocity_verlet.run, order=2, kind="explicit",
        purpose="free motion and energy: second order for the price of one evaluation",
        fails="The same limit as semi-implicit Euler, a quarter lower at a damping ratio of 0.3. In contact the force "
        "saved from the last step is no longer valid, so a step costs two evaluations, and the projection leaves "
        "first order only.",
    ),
    "rk4": Method(
        label="Runge-Kutta 4", run=rk4.run, order=4, kind="explicit",
        purpose="references, and smooth motion to tight tolerances",
        fails="Four evaluations reach only 1.4 times as far (dt < 2.8 / omega; 1.9 times at a damping ratio of 0.3), "
        "so where the stiffest spring sets the step it costs most; kinks (the knee of Eq. (1), contact) reduce "
        "the order.",
    ),
    "backward_euler": Method(
        label="backward Euler", run=backward_euler.run, order=1, kind="implicit",
        purpose="stiff bodies at one step a tick, where only the state at rest matters",
        fails="It never diverges, but damps motion: a mode loses the factor 1 / (1 + (omega dt)^2) of its energy "
        "each step. Fingertips meet a stiff layer without friction, and sink in by force over stiffness.",
    ),
    "implicit_midpoint": Method(
        label="implicit midpoint", run=implicit_midpoint.run, order=2, kind="implicit",
        purpose="stiff free bodies that must keep oscillating",
        fails="A mode too fast for the step flips sign each step and never decays: pressed by a fingertip the body "
        "rattles, the force may be twice too large, and some steps find no solution (they are counted).",
    ),
    "tr_bdf2": Method(
        label="TR-BDF2", run=tr_bdf2.run, order=2, kind="implicit",
        purpose="stiff bodies to a tolerance: second order, yet stiff modes decay",
        fails="Two solves a step: where the stiffest mode must be followed, explicit methods are many times cheaper. "
        "Its stages do not quite keep angular momentum: where omega dt exceeds some hundreds a free body turns. "
        "Fingertips as with backward Euler.",
    ),
    "xpbd": Method(
        label="XPBD, small substeps", run=xpbd.run, order=1, kind="sweeping",
        purpose="never to diverge, at a bounded cost per step",
        fails="Laws that hold against each other answer with k / (1 + h^2 k w): where h^2 k w exceeds a few hundredths "
        "the body is too soft and the force on the fingertip too small. It damps as backward Euler does, and a "
        "step costs several explicit ones, so it pays only where explicit steps diverge.",
    ),
    "vertex_block_descent": Method(
        label="vertex block descent", run=vertex_block_descent.run, order=1, kind="sweeping",
        purpose="stiff bodies of few vertices at one step a tick, at a bounded cost per step",
        fails="A sweep spreads a force over only a few edges: on fine meshes, where h^2 k / m is large, "
        "four sweeps leave the skin round a fingertip behind, and the force on it is many times too large "
        "until the body is at rest. It damps as backward Euler does. Fingertips meet a stiff layer, without friction.",
    ),
}  # fmt: skip
