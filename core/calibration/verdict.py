"""What an identification is worth: its press beside the measured points and what a hand can tell, and a prediction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import Floats
from ..body.estimate import FINGERTIP
from ..mesh.surface import Mesh
from .calibrate import Calibration
from .identify import NOTICEABLE_FORCE, NOTICEABLE_STIFFNESS, Identification
from .indent import Indenter, Site, press_curve, reach

ROWS = 25  # of a predicted press
# a bed of springs without a skin lets a sphere part it: F = pi kappa (R - x) x^2, which falls beyond x = 2 R / 3. A
# mesh is a skin of its own, the more so the coarser it is: `python -m core paper` tells how much
TIP_REACH = 2 / 3  # of the fingertip's radius
_TIP_NOTE = (
    "This is a prediction, not a fit, and one for this mesh: a coarse one answers too much. It ends at two thirds of "
    "the tip's radius: deeper, so small a tip parts a skin as slack as this, the more easily the finer the mesh."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Hold an identification, the tip, the mesh, and how far the simulated press is off.

    patch: radius [m] of what pressed, and how many vertices were under it if it is flat.
    force_off: the largest share of a force that it is off.  stiffness_off: of K1 and K2 (None: no row there), shares.
    measured_rms: to the measured points, share of full scale.  tip_depth [m], tip_force [N]: (m,) each, of the same
    material pressed by a fingertip: a prediction.
    """

    found: Identification
    indenter: Indenter
    mesh: Mesh
    patch: tuple[float, int]
    force_off: float
    stiffness_off: tuple[float | None, float | None]
    measured_rms: float
    tip_depth: Floats
    tip_force: Floats


def judge(calibration: Calibration, found: Identification, mesh: Mesh, indenter: Indenter, site: Site) -> Verdict:
    """Compare a simulated press with what was measured, and press the same material with a fingertip."""
    depth, force = calibration.press.depth, calibration.press.force
    here = (depth >= 0) & (depth <= found.depths[-1])
    simulated = np.interp(depth[here], np.append(0.0, found.depths), np.append(0.0, found.simulated))
    deepest = min(float(found.depths[-1]), TIP_REACH * FINGERTIP)
    fingertip = Indenter(shape="sphere", radius=FINGERTIP)
    tip_depth, tip_force = press_curve(mesh, found.material, fingertip, site, deepest, rows=ROWS)
    return Verdict(
        found=found, indenter=indenter, mesh=mesh, patch=(reach(mesh, indenter), int(site.under.sum())),
        force_off=float(found.off.max()), stiffness_off=_slopes_off(found),
        measured_rms=float(np.sqrt(((simulated - force[here]) ** 2).mean()) / force.max()),
        tip_depth=tip_depth, tip_force=tip_force,
    )  # fmt: skip


def verdict_json(verdict: Verdict) -> dict[str, Any]:
    """Return what a program wants to know; depths in mm, forces in N, deviations in percent."""
    found, constants = verdict.found, verdict.found.material.constants
    assert constants is not None
    return {
        "kappa1": constants.kappa1 / 1e6,
        "kappa2": constants.kappa2 / 1e6,
        "d0": constants.d0 * 1e3,
        "membrane_scale": constants.membrane_scale,
        "units": {"kappa1": "N/cm3", "kappa2": "N/cm3", "d0": "mm", "membrane_scale": "1"},
        "indenter": verdict.indenter.shape,
        "tip_radius": verdict.indenter.radius * 1e3,
        "patch_radius": verdict.patch[0] * 1e3,
        "patch_vertices": verdict.patch[1] if verdict.indenter.shape != "sphere" else None,
        "vertices": len(verdict.mesh.rest_positions),
        "size": verdict.mesh.size * 1e3,
        "rms_percent": 100 * found.rms,
        "measured_rms_percent": 100 * verdict.measured_rms,
        "force_off_percent": 100 * verdict.force_off,
        "stiffness_off_percent": [None if off is None else 100 * off for off in verdict.stiffness_off],
        "noticeable_force_percent": [100 * share for share in NOTICEABLE_FORCE],
        "noticeable_stiffness_percent": [100 * share for share in NOTICEABLE_STIFFNESS],
        "volume_change_percent": 100 * found.volume_change,
        "sweeps": found.sweeps,
        "stopped": found.stopped,
        "notes": list(found.notes),
        "press": {
            "depth": (1e3 * found.depths).tolist(), "wanted": found.wanted.tolist(),
            "simulated": found.simulated.tolist(),
        },
        "prediction": {
            "indenter": "sphere", "tip_radius": 1e3 * FINGERTIP, "depth": (1e3 * verdict.tip_depth).tolist(),
            "force": verdict.tip_force.tolist(), "note": _TIP_NOTE,
        },
    }  # fmt: skip


def verdict_lines(verdict: Verdict) -> list[str]:
    """Return what a person wants to read."""
    found, constants = verdict.found, verdict.found.material.constants
    assert constants is not None
    radius, under = verdict.patch
    tip = f"sphere of {1e3 * radius:.3g} mm radius"
    if verdict.indenter.shape != "sphere":
        tip = f"{verdict.indenter.shape}: a flat patch of {1e3 * radius:.3g} mm radius, {under} vertices"
    body = f"{len(verdict.mesh.rest_positions)} vertices, {1e3 * verdict.mesh.size:.4g} mm"
    slopes = " and ".join(
        f"{name} by {100 * off:.1f} %"
        for name, off in zip(("K1", "K2"), verdict.stiffness_off, strict=True)
        if off is not None
    )
    middle = len(verdict.tip_depth) // 2
    pairs = " and ".join(
        f"{verdict.tip_force[i]:.3g} N at {1e3 * verdict.tip_depth[i]:.3g} mm"
        for i in (middle, len(verdict.tip_depth) - 1)
    )
    return [
        f"  Simulated press ({tip}; {body}) down to {1e3 * found.depths[-1]:.3g} mm:",
        f"    kappa1 = {constants.kappa1 / 1e6:.4g} N/cm3, kappa2 = {constants.kappa2 / 1e6:.4g} N/cm3, "
        f"d0 = {1e3 * constants.d0:.4g} mm, scale on k {constants.membrane_scale:.2g}",
        f"    off by {100 * found.rms:.2f} % of full scale from the law (RMS), {100 * verdict.measured_rms:.2f} % from "
        f"the points; volume {100 * found.volume_change:.3f} %",
        f"    force off by {100 * verdict.force_off:.1f} % at worst, at {1e3 * found.depths[found.off.argmax()]:.3g} "
        f"mm (a hand tells {_range(NOTICEABLE_FORCE)}), {slopes} (a hand tells {_range(NOTICEABLE_STIFFNESS)})",
        *(f"    {note}" for note in found.notes),
        f"    A {1e3 * FINGERTIP:.3g} mm fingertip would feel {pairs}. {_TIP_NOTE}",
    ]


def _slopes_off(found: Identification) -> tuple[float | None, float | None]:
    """Return how far the slopes of the simulated press are off K1 and K2, as shares."""
    before = found.depths <= found.material.x0
    pieces = (before, found.material.K1), (~before, found.material.K2)
    off = [
        abs(float(np.polyfit(found.depths[rows], found.simulated[rows], 1)[0]) / slope - 1) if rows.sum() > 2 else None
        for rows, slope in pieces
    ]
    return off[0], off[1]


def _range(shares: tuple[float, float]) -> str:
    return f"{100 * shares[0]:.0f} to {100 * shares[1]:.0f} %"
