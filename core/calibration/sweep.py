"""The fit within an identification: what a press to each depth says about the model constants."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats
from ..material import Material, ModelConstants
from ..mesh.surface import Mesh
from .indent import Indenter, Site, press

STATIONS = 12  # depths of a sweep that is fitted
CHECKED = 30  # depths of the sweep that checks the result
SWEEPS = 24  # at most in an identification
USUAL = 3  # sweeps before that one: more are rare
SWEEPS_OF_A_FIT = 10
ALLOWED = 0.10  # of the force, or
ALLOWED_FORCE = 0.3  # [N] whichever is more: what a depth may be off
WEAK = 0.02  # of full scale: what a depth of a weak press may be off
GAIN = 0.05  # of the squared error: a step that brings less is the last of a fit
LONGEST = np.array([1.0, 1.0, 0.1])  # step in the logarithms: a knee that passes the deepest depth is lost
_NAMES = ("kappa1", "kappa2", "d0", "membrane_scale")


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What is pressed, by what, and where."""

    mesh: Mesh
    material: Material
    indenter: Indenter
    site: Site


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A press to one depth after another.

    depths: (m,) that were reached [m].
    wanted: (m,) forces of the measured law there [N].
    simulated: (m,) forces of the simulated press there [N].
    slopes: (m, 4) derivatives of the latter in the logarithms of the constants [N].
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


def constants_of(logs: Floats) -> ModelConstants:
    """Return the constants with these logarithms (4,)."""
    return ModelConstants(**dict(zip(_NAMES, np.exp(logs).tolist(), strict=True)))


def fitted(
    task: Task, logs: Floats, sweep: Sweep, depths: Floats, sweeps: int
) -> Generator[float, None, tuple[Floats, Sweep, int]]:
    """Fit kappa1, kappa2 and d0 with the skin's scale fixed; return the logarithms, their sweep, all sweeps so far."""
    damping, last = 1e-4, min(sweeps + SWEEPS_OF_A_FIT, SWEEPS)
    while sweeps < last and sweep.whole:
        candidate = logs + np.append(_step(sweep, damping), 0.0)
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
    jacobian = (sweep.slopes / sweep.allowed[:, None])[:, :3]
    matrix = jacobian.T @ jacobian
    matrix = matrix + np.diag(damping * np.diag(matrix) + 1e-9)
    return np.clip(-np.linalg.solve(matrix, jacobian.T @ sweep.errors), -LONGEST, LONGEST)


def swept(
    task: Task, logs: Floats, depths: Floats, sweeps: int, *, last: bool = False
) -> Generator[float, None, Sweep]:
    """Press to every depth; yield the share of the identification that is done after each."""
    material = replace(task.material, constants=constants_of(logs))
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
    pulls = np.array([np.zeros(4), *(station.pull for station in stations)])
    # dF/dc = d/dx (dE/dc), from nothing at the touch
    slopes = np.gradient(pulls, np.append(0.0, reached), axis=0)[1:] if len(stations) > 1 else np.zeros((0, 4))
    return Sweep(
        depths=reached, wanted=np.array([task.material.law(depth) for depth in reached.tolist()]),
        simulated=np.array([station.force for station in stations]),
        slopes=slopes + np.array([station.slope for station in stations]).reshape(-1, 4),
        volume_change=max((abs(station.volume_change) for station in stations), default=0.0),
        whole=len(stations) == len(depths),
    )  # fmt: skip
