"""The fit within an identification: what a press to each depth says about the model constants."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats
from ..material import Indenter, Material, ModelConstants
from ..mesh.surface import Mesh
from .indent import Site, press

STATIONS = 12  # depths of a sweep that is fitted
CHECKED = 20  # depths of the sweep that checks the result
SWEEPS = 10  # at most in an identification
USUAL = 4  # sweeps before that one: more are rare
ALLOWED = 0.10  # of the force, or
ALLOWED_FORCE = 0.3  # [N] whichever is more: what a depth may be off
WEAK = 0.02  # of full scale: what a depth of a weak press may be off
GAIN = 0.05  # of the squared error: a step that brings less is the last of a fit
GOOD = 0.1  # of what is allowed, at the worst depth: no further fit
LONGEST = np.array([1.0, 1.0, 0.1])  # step in the logarithms: a knee that passes the deepest depth is lost
_NAMES = ("kappa1", "kappa2", "d0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What is pressed, by what, and where; and the factor on k, which is not fitted."""

    mesh: Mesh
    material: Material
    indenter: Indenter
    site: Site
    membrane_scale: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A press to one depth after another.

    depths: (m,) that were reached [m].
    wanted: (m,) forces of the measured law there [N].
    simulated: (m,) forces of the simulated press there [N].
    slopes: (m, 3) derivatives of the latter in the logarithms of the constants [N].
    volume_change: largest, as a share.
    whole: whether every depth asked for was reached.
    """

    depths: Floats
    wanted: Floats
    simulated: Floats
    slopes: Floats
    volume_change: float
    whole: bool

    @property
    def allowed(self) -> Floats:
        """Return what each force may be off [N]."""
        return np.maximum(ALLOWED * self.wanted, min(ALLOWED_FORCE, WEAK * float(self.wanted.max())))

    @property
    def errors(self) -> Floats:
        """Return the deviations over what is allowed."""
        return (self.simulated - self.wanted) / self.allowed

    @property
    def cost(self) -> float:
        """Return the sum of the squared errors, inf where a depth was not reached."""
        return float((self.errors**2).sum()) if self.whole else math.inf

    @property
    def worst(self) -> float:
        """Return the largest error, inf where a depth was not reached."""
        return float(np.abs(self.errors).max()) if self.whole else math.inf

    @property
    def rms(self) -> float:
        """Return the deviation as a share of full scale."""
        return float(np.sqrt(((self.simulated - self.wanted) ** 2).mean()) / self.wanted.max())


def constants_of(task: Task, logs: Floats) -> ModelConstants:
    """Return the constants with these logarithms (3,)."""
    return ModelConstants(
        membrane_scale=task.membrane_scale, **dict(zip(_NAMES, np.exp(logs).tolist(), strict=True))
    )


def fitted(
    task: Task, logs: Floats, sweep: Sweep, depths: Floats
) -> Generator[float, None, tuple[Floats, Sweep, int]]:
    """Fit kappa1, kappa2 and d0; return their logarithms, the sweep with them, and how many sweeps there were."""
    damping, sweeps = 1e-4, 1
    while sweeps < SWEEPS and sweep.whole and sweep.worst > GOOD:
        candidate = logs + _step(sweep, damping)
        found = yield from swept(task, candidate, depths, sweeps)
        sweeps += 1
        gain = 1 - found.cost / max(sweep.cost, 1e-30)
        if gain > 0:
            logs, sweep = candidate, found
        if 0 <= gain < GAIN:
            break
        damping = damping / 5 if gain > 0 else 30 * damping
    return logs, sweep, sweeps


def _step(sweep: Sweep, damping: float) -> Floats:
    """Return the damped Gauss-Newton step (3,)."""
    jacobian = sweep.slopes / sweep.allowed[:, None]
    matrix = jacobian.T @ jacobian
    matrix = matrix + np.diag(damping * np.diag(matrix) + 1e-9)
    return np.clip(-np.linalg.solve(matrix, jacobian.T @ sweep.errors), -LONGEST, LONGEST)


def swept(
    task: Task, logs: Floats, depths: Floats, sweeps: int, *, last: bool = False
) -> Generator[float, None, Sweep]:
    """Press to every depth; yield the share of the identification that is done after each."""
    material = replace(task.material, constants=constants_of(task, logs))
    stations = []
    for station in press(task.mesh, material, task.indenter, task.site, depths.tolist()):
        if not station.found:
            break
        stations.append(station)
        done = STATIONS * sweeps + len(stations)
        # never all of it: what was found is still to be put together
        left = 1 + CHECKED - len(stations) if last else CHECKED + max(STATIONS * USUAL - done, 0)
        yield done / (done + left)
    reached = np.array([station.depth for station in stations])
    pulls = np.array([np.zeros(3), *(station.pull for station in stations)])
    # dF/dc = d/dx (dE/dc), from nothing at the touch
    slopes = np.gradient(pulls, np.append(0.0, reached), axis=0)[1:] if len(stations) > 1 else np.zeros((0, 3))
    return Sweep(
        depths=reached, wanted=np.array([task.material.law(depth) for depth in reached.tolist()]),
        simulated=np.array([station.force for station in stations]),
        slopes=slopes + np.array([station.slope for station in stations]).reshape(-1, 3),
        volume_change=max((abs(station.volume_change) for station in stations), default=0.0),
        whole=len(stations) == len(depths),
    )  # fmt: skip
