"""Model constants such that a simulated press with the measuring tip answers K(x) of the material on its mesh.

What the skin carries and what shape matching carries can hardly be distinguished by one curve, so the skin's scale is
not fitted: it is the largest that still lets the press follow the curve well. For each scale tried kappa1, kappa2 and
d0 are fitted by least squares over their logarithms (Levenberg and Marquardt). One sweep of equilibria gives the
forces and, by the energy's slopes, their derivatives: see `indent`. Under a flat tip all of it is numpy, for the
equilibrium has no native twin; a sphere presses in a session, native where there is a native core.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..material import Material, ModelConstants
from ..mesh.surface import Mesh
from .indent import CLEAR, Indenter, Site
from .sweep import CHECKED, STATIONS, SWEEPS, Sweep, Task, constants_of, fitted, swept

GOAL = (0.35, 0.5)  # of what is allowed, at the worst depth: 5 % of a force is below what can be felt
FIRST_SHARE = 0.1  # of the force: what the skin may carry in the first guess
LIMITS = (1e-5, 1.0)  # of the skin's scale
GROWS = 0.8  # power of the scale with which the worst error grows
LARGEST_CHANGE = 8.0  # of the scale from one fit to the next
NOTICEABLE_FORCE = (0.06, 0.08)  # just-noticeable difference of a force, as a share of it: from, to
# a bed of springs without a skin lets a sphere part it: F = pi kappa (R - x) x^2, which falls beyond x = 2 R / 3. A
# mesh is a skin of its own, the more so the coarser it is
TIP_REACH = 2 / 3  # of a fingertip's radius: how deep it may go into a skin as slack as an identified one


@dataclass(frozen=True, slots=True, kw_only=True)
class Identification:
    """Model constants that were identified, and how well the press with them follows the measured law.

    material: with the constants.
    depths: (m,) of the press that checks them [m].
    wanted: (m,) forces of the law there [N].
    simulated: (m,) forces of the simulated press there [N].
    rms: RMS error as a share of full scale.
    worst: largest error over what is allowed at its depth.
    volume_change: largest, as a share.
    sweeps: number of presses that were simulated.
    stopped: "" or why the press ends before the depth asked for.
    notes: messages for the artist.
    """

    material: Material
    depths: Floats
    wanted: Floats
    simulated: Floats
    rms: float
    worst: float
    volume_change: float
    sweeps: int
    stopped: str
    notes: tuple[str, ...]

    @property
    def off(self) -> Floats:
        """Return the error (m,) of each force as a share of the force wanted there."""
        return np.abs(self.simulated / self.wanted - 1)


def identification(
    mesh: Mesh, material: Material, indenter: Indenter, site: Site, deepest: float
) -> Generator[float, None, Identification]:
    """Identify model constants in steps of one equilibrium each, for a timer.

    Args:
        mesh: in the size of the real object [m].
        material: K1, K2, x0 measured with the indenter; its constants are ignored.
        indenter: the tip that measured.
        site: where it presses.
        deepest: depth [m] down to which the constants must hold.

    Yields:
        the share that is done: an estimate, for how many sweeps the fit takes is not known before.

    Returns:
        what was found.

    Raises:
        DimpleError: the body finds no rest under the tip.
    """
    task = Task(mesh=mesh, material=material, indenter=indenter, site=site)
    depths, stopped = _depths(deepest, site)
    logs = np.log(_first_guess(task, depths[-1]))
    sweep = yield from swept(task, logs, depths, 0)
    if not sweep.whole:
        depths, stopped = sweep.depths, _lost_message(sweep)
        sweep = replace(sweep, whole=True)
    sweeps, best = 1, None
    while sweeps < SWEEPS:
        logs, sweep, sweeps = yield from fitted(task, logs, sweep, depths, sweeps)
        if best is None or _preferred((logs, sweep), best):
            best = logs, sweep
        elif sweep.worst > GOAL[1]:  # a smaller scale does not help
            break
        change = _change(sweep.worst, math.exp(logs[3]))
        if abs(change) < 0.01:
            break
        logs = logs + [0, 0, 0, change]
        sweep = yield from swept(task, logs, depths, sweeps)
        sweeps += 1
    logs, sweep = best or (logs, sweep)
    fine = depths[-1] * np.arange(1, CHECKED + 1) / CHECKED
    check = yield from swept(task, logs, fine, sweeps, last=True)
    if not check.whole:
        stopped = _lost_message(check)
    constants = constants_of(logs)
    return Identification(
        material=replace(material, constants=constants), depths=check.depths, wanted=check.wanted,
        simulated=check.simulated, rms=check.rms, worst=float(np.abs(check.errors).max()),
        volume_change=check.volume_change, sweeps=sweeps + 1, stopped=stopped,
        notes=tuple(filter(None, (_scale_message(constants), stopped, _miss_message(check, indenter)))),
    )  # fmt: skip


def _scale_message(constants: ModelConstants) -> str:
    """Return a message about what the factor on k means."""
    scale = constants.membrane_scale
    if scale > 0.99:
        return "The skin keeps its own k."
    return (
        f"The skin's k is taken at {100 * scale:.2g} % of its value, about the most with which the press follows what "
        "was measured: a skin stretched over a small tip answers not in proportion, and far more. The shape matching "
        "carries the rest."
    )


def _depths(deepest: float, site: Site) -> tuple[Floats, str]:
    """Return the depths (m,) [m] that are fitted, and why not down to the deepest, or ""."""
    share, clear = np.arange(1, STATIONS + 1) / STATIONS, CLEAR * site.thickness
    if deepest <= clear:
        return deepest * share, ""
    return clear * share, (
        f"Deeper than {1e3 * clear:.3g} mm the tip would meet the far side of the object, "
        f"which is {1e3 * site.thickness:.3g} mm thick there."
    )


def _lost_message(sweep: Sweep) -> str:
    if len(sweep.depths) < 4:
        raise DimpleError("The simulated body finds no rest under the tip. Use a finer or simpler mesh.")
    return f"Deeper than {1e3 * sweep.depths[-1]:.3g} mm the simulated body finds no rest: its skin folds."


def _miss_message(sweep: Sweep, indenter: Indenter) -> str:
    """Return a message about where the simulated press is off by more than allowed, "" where it is nowhere."""
    at = int(np.abs(sweep.errors).argmax())
    if abs(sweep.errors[at]) <= 1:
        return ""
    there = f"{sweep.simulated[at]:.3g} N instead of {sweep.wanted[at]:.3g} N"
    why = " A round tip touches more as it sinks in, so it starts too soft." if indenter.shape == "sphere" else ""
    return f"The simulated press is off the most at {1e3 * sweep.depths[at]:.3g} mm: {there}.{why}"


def _first_guess(task: Task, deepest: float) -> list[float]:
    """Return constants to start from.

    The bed under the tip carries all, K = kappa A. The skin round it carries a little, at the knee and at the deepest.
    A spring of the length h of an edge whose end goes down by x answers k (sqrt(h^2 + x^2) - h) x / sqrt(h^2 + x^2);
    about as many as six for each vertex at the rim do.
    """
    mesh, material, under = task.mesh, task.material, task.site.under
    area = float(mesh.vertex_areas[under].sum())
    rim = under[mesh.springs].sum(axis=1) == 1
    edge = float(mesh.rest_lengths[rim if rim.any() else slice(None)].mean())

    def share(depth: float) -> float:
        long = math.hypot(edge, depth)
        skin = int(rim.sum()) * material.k * (long - edge) * depth / long
        return FIRST_SHARE * material.law(depth) / max(skin, 1e-30)

    scale = min(share(material.x0), share(deepest))
    return [material.K1 / area, material.K2 / area, material.x0, min(max(scale, LIMITS[0]), LIMITS[1])]


def _preferred(one: tuple[Floats, Sweep], other: tuple[Floats, Sweep]) -> bool:
    """Return whether one fit is better: near enough with more of the skin, else nearer."""
    near = one[1].worst <= GOAL[1], other[1].worst <= GOAL[1]
    return bool(one[0][3] > other[0][3]) if all(near) else one[1].worst < other[1].worst


def _change(worst: float, scale: float) -> float:
    """Return what to add to the logarithm of the skin's scale so that the worst error comes to the goal."""
    low, high = GOAL
    if low <= worst <= high:
        return 0.0
    most = math.log(LARGEST_CHANGE)
    change = math.log((low + high) / 2 / max(worst, 1e-9)) / GROWS if math.isfinite(worst) else -most
    change = min(max(change, -most), most)
    return min(max(change, math.log(LIMITS[0] / scale)), math.log(LIMITS[1] / scale))
