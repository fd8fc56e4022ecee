"""How good an identification is: its press beside the measured points and the just-noticeable difference.

The same material pressed by a fingertip comes with it, as a prediction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from core.base import Floats
from core.body.estimate import reach
from core.calibration.calibrate import Calibration
from core.calibration.identify import NOTICEABLE_FORCE, Identification
from core.calibration.indent import Site
from core.calibration.misfit import Miss, largest_miss
from core.material import Indenter, ModelConstants
from core.mesh.surface import Mesh

from .virtual_press import press_curve

NOTICEABLE_STIFFNESS = (0.08, 0.22)  # just-noticeable difference of a stiffness, as a share of it: from, to
FINGERTIP = 0.010  # [m] radius of the fingertip whose press is predicted
ROWS = 25  # of a predicted press
_TIP_NOTE = "This is a prediction, not a fit."


@dataclass(frozen=True, slots=True, kw_only=True)
class Assessment:
    """An identification and the errors of its simulated press.

    found: the identification.
    indenter: the tip that measured.
    mesh: what was pressed.
    patch: radius [m] of what pressed, and how many vertices were under it if it is flat.
    force_error: the largest error of a force against the law, as a share of it.
    measured_miss: the largest error of a force against the measured points, None where there are none.
    stiffness_errors: of K1 and K2, as shares; None where there are too few rows.
    measured_rms: RMS distance to the measured points, as a share of full scale.
    tip_depth: (m,) of the predicted press with a fingertip [m].
    tip_force: (m,) of the predicted press with a fingertip [N].
    """

    found: Identification
    indenter: Indenter
    mesh: Mesh
    patch: tuple[float, int]
    force_error: float
    measured_miss: Miss | None
    stiffness_errors: tuple[float | None, float | None]
    measured_rms: float
    tip_depth: Floats
    tip_force: Floats


def assess(calibration: Calibration, found: Identification, mesh: Mesh, indenter: Indenter, site: Site) -> Assessment:
    """Compare a simulated press with what was measured, and press the same material with a fingertip."""
    depth, force = calibration.loading.depth, calibration.loading.force
    here = (depth >= 0) & (depth <= found.depths[-1])
    simulated = np.interp(depth[here], np.append(0.0, found.depths), np.append(0.0, found.simulated))
    deepest = min(float(found.depths[-1]), FINGERTIP)
    fingertip = Indenter(shape="sphere", radius=FINGERTIP)
    tip_depth, tip_force = press_curve(mesh, found.material, fingertip, site, deepest, rows=ROWS)
    return Assessment(
        found=found, indenter=indenter, mesh=mesh, patch=(reach(indenter, mesh.size), int(site.under.sum())),
        force_error=float(found.off.max()), measured_miss=largest_miss(depth[here], force[here], simulated),
        stiffness_errors=_slope_errors(found),
        measured_rms=float(np.sqrt(((simulated - force[here]) ** 2).mean()) / force.max()),
        tip_depth=tip_depth, tip_force=tip_force,
    )  # fmt: skip


def assessment_json(assessment: Assessment) -> dict[str, Any]:
    """Return an assessment as plain data; depths in mm, forces in N, errors in percent."""
    found, constants = assessment.found, assessment.found.material.constants
    assert constants is not None
    return {
        "kappa1": constants.kappa1 / 1e6,
        "kappa2": constants.kappa2 / 1e6,
        "d0": constants.d0 * 1e3,
        "membrane_scale": constants.membrane_scale,
        "tension": (constants.tension or 0.0) / 1e3,
        "pieces": [{"knee": 1e3 * knee, "more": more / 1e6} for knee, more in constants.pieces],
        "units": {
            "kappa1": "N/cm3", "kappa2": "N/cm3", "d0": "mm", "membrane_scale": "1", "tension": "N/mm", "knee": "mm",
            "more": "N/cm3",
        },
        "indenter": assessment.indenter.shape,
        "tip_radius": assessment.indenter.radius * 1e3,
        "patch_radius": assessment.patch[0] * 1e3,
        "patch_vertices": assessment.patch[1] if assessment.indenter.shape != "sphere" else None,
        "vertices": len(assessment.mesh.rest_positions),
        "size": assessment.mesh.size * 1e3,
        "rms_percent": 100 * found.rms,
        "measured_rms_percent": 100 * assessment.measured_rms,
        "force_off_percent": 100 * assessment.force_error,
        "force_off_points_percent": None if assessment.measured_miss is None else 100 * assessment.measured_miss.share,
        "stiffness_off_percent": [None if off is None else 100 * off for off in assessment.stiffness_errors],
        "noticeable_force_percent": [100 * share for share in NOTICEABLE_FORCE],
        "noticeable_stiffness_percent": [100 * share for share in NOTICEABLE_STIFFNESS],
        "volume_change_percent": 100 * found.volume_change,
        "stopped": found.stopped,
        "notes": list(found.notes),
        "press": {
            "depth": (1e3 * found.depths).tolist(), "wanted": found.wanted.tolist(),
            "simulated": found.simulated.tolist(),
        },
        "prediction": {
            "indenter": "sphere", "tip_radius": 1e3 * FINGERTIP, "depth": (1e3 * assessment.tip_depth).tolist(),
            "force": assessment.tip_force.tolist(), "note": _TIP_NOTE,
        },
    }  # fmt: skip


def assessment_lines(assessment: Assessment) -> list[str]:
    """Return an assessment as lines of text."""
    found, constants = assessment.found, assessment.found.material.constants
    assert constants is not None
    radius, under = assessment.patch
    tip = f"sphere of {1e3 * radius:.3g} mm radius"
    if assessment.indenter.shape != "sphere":
        tip = f"{assessment.indenter.shape}: a flat patch of {1e3 * radius:.3g} mm radius, {under} vertices"
    body = f"{len(assessment.mesh.rest_positions)} vertices, {1e3 * assessment.mesh.size:.4g} mm"
    slopes = " and ".join(
        f"{name} by {100 * off:.1f} %"
        for name, off in zip(("K1", "K2"), assessment.stiffness_errors, strict=True)
        if off is not None
    )
    middle = len(assessment.tip_depth) // 2
    pairs = " and ".join(
        f"{assessment.tip_force[i]:.3g} N at {1e3 * assessment.tip_depth[i]:.3g} mm"
        for i in (middle, len(assessment.tip_depth) - 1)
    )
    return [
        f"  Simulated press ({tip}; {body}) down to {1e3 * found.depths[-1]:.3g} mm:",
        f"    the bed: {_bed(constants)};",
        f"    tension {(constants.tension or 0.0) / 1e3:.3g} N/mm, scale on k {constants.membrane_scale:.2g}",
        f"    RMS error {100 * found.rms:.2f} % of full scale from the law, {100 * assessment.measured_rms:.2f} % from "
        f"the points; volume {100 * found.volume_change:.3f} %",
        f"    largest force error {100 * assessment.force_error:.1f} % from the law, at "
        f"{1e3 * found.depths[found.off.argmax()]:.3g} mm{_from_points(assessment.measured_miss)} "
        f"(just noticeable: {_range(NOTICEABLE_FORCE)}), "
        f"{slopes} (just noticeable: {_range(NOTICEABLE_STIFFNESS)})",
        *(f"    {note}" for note in found.notes),
        f"    A {1e3 * FINGERTIP:.3g} mm fingertip would meet {pairs}. {_TIP_NOTE}",
    ]


def bed_slopes(constants: ModelConstants) -> Floats:
    """Return the slopes (m,) [N/m3] of the bed's law from the touch on, one for each piece."""
    return constants.kappa1 + np.cumsum([0.0, *(more for _, more in constants.pieces)])


def _bed(constants: ModelConstants) -> str:
    """Return the law of the bed in words: its slopes, and where each begins."""
    begins = [0.0, *(knee for knee, _ in constants.pieces)]
    slopes = [f"{slope / 1e6:.3g} N/cm3" for slope in bed_slopes(constants).tolist()]
    return ", ".join(
        f"{slope} from {1e3 * begin:.3g} mm"
        for before, slope, begin in zip(["", *slopes], slopes, begins, strict=False)
        if slope != before
    )


def _from_points(miss: Miss | None) -> str:
    return "" if miss is None else f", {100 * miss.share:.1f} % from the points, at {1e3 * miss.depth:.3g} mm"


def _slope_errors(found: Identification) -> tuple[float | None, float | None]:
    """Return the errors of the simulated press's slopes against K1 and K2, as shares."""
    before = found.depths <= found.material.x0
    pieces = (before, found.material.K1), (~before, found.material.K2)
    errors = [
        abs(float(np.polyfit(found.depths[rows], found.simulated[rows], 1)[0]) / slope - 1) if rows.sum() > 2 else None
        for rows, slope in pieces
    ]
    return errors[0], errors[1]


def _range(shares: tuple[float, float]) -> str:
    return f"{100 * shares[0]:.0f} to {100 * shares[1]:.0f} %"
