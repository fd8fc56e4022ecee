"""Model constants such that a simulated press with the measuring tip answers K(x) of the material on its mesh.

kappa1, kappa2 and d0 are fitted by least squares over their logarithms (Levenberg and Marquardt), from the closed form
on. One sweep of presses gives the forces and, by the energy's slopes, their derivatives: see `indent`. The factor on k
and the spread are not fitted: one curve hardly tells them from the rest.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..body.estimate import estimate
from ..material import Indenter, Material, ModelConstants
from ..mesh.surface import Mesh
from .indent import CLEAR, Site
from .sweep import CHECKED, STATIONS, Sweep, Task, constants_of, fitted, swept

NOTICEABLE_FORCE = (0.06, 0.08)  # just-noticeable difference of a force, as a share of it: from, to


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
    first = estimate(replace(material, constants=None, indenter=indenter), mesh.size)
    task = Task(mesh=mesh, material=material, indenter=indenter, site=site, membrane_scale=first.membrane_scale)
    depths, stopped = _depths(deepest, site)
    logs = np.log([first.kappa1, first.kappa2, first.d0])
    sweep = yield from swept(task, logs, depths, 0)
    if not sweep.whole:
        depths, stopped = sweep.depths, _lost_message(sweep)
        sweep = replace(sweep, whole=True)
    logs, sweep, sweeps = yield from fitted(task, logs, sweep, depths)
    fine = depths[-1] * np.arange(1, CHECKED + 1) / CHECKED
    check = yield from swept(task, logs, fine, sweeps, last=True)
    if not check.whole:
        stopped = _lost_message(check)
    constants = constants_of(task, logs)
    return Identification(
        material=replace(material, constants=constants, indenter=indenter), depths=check.depths, wanted=check.wanted,
        simulated=check.simulated, rms=check.rms, worst=float(np.abs(check.errors).max()),
        volume_change=check.volume_change, sweeps=sweeps + 1, stopped=stopped,
        notes=tuple(filter(None, (_scale_message(constants), stopped, _miss_message(check, indenter)))),
    )  # fmt: skip


def _scale_message(constants: ModelConstants) -> str:
    """Return a message about what the factor on k means."""
    scale = constants.membrane_scale
    if scale > 0.99:
        return "The springs of the surface keep their own k."
    return (
        f"k is taken at {100 * scale:.2g} % of its value: springs as stiff would answer far more than was measured, "
        "and buckle. Shape matching carries the rest."
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
    return f"Deeper than {1e3 * sweep.depths[-1]:.3g} mm the simulated body finds no rest."


def _miss_message(sweep: Sweep, indenter: Indenter) -> str:
    """Return a message about where the simulated press is off by more than allowed, "" where it is nowhere."""
    at = int(np.abs(sweep.errors).argmax())
    if abs(sweep.errors[at]) <= 1:
        return ""
    there = f"{sweep.simulated[at]:.3g} N instead of {sweep.wanted[at]:.3g} N"
    why = " A round tip touches more as it sinks in, so it starts too soft." if indenter.shape == "sphere" else ""
    return f"The simulated press is off the most at {1e3 * sweep.depths[at]:.3g} mm: {there}.{why}"
