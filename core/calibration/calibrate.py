"""From a file to constants: reading, preparing and fitting as one, with all that was found on the way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from ..material import Material
from .contact import settle
from .fit import Fit, fit_law
from .indent import POINT, Indenter
from .prepare import Press, prepare
from .question import Answers
from .reader import Measurement, read_measurement
from .surface import Surface, surface_constants

_POOR = 0.05  # of full scale, RMS: a law that misses the curve by more is said to
_WIDENED = 2.0  # times wider intervals are explained
_DEPTHS, _FORCES = (2e-5, 0.5), (1e-3, 2e4)  # [m], [N]: presses outside have the wrong unit more often than not


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Hold a calibration: the file, its press from the fitted touch, the fit; the object's length [m] and the tip.

    surface: k both ways, None without a length.  notes, warnings: sentences for the artist.
    """

    measurement: Measurement
    press: Press
    fit: Fit
    length: float | None
    tip: Indenter
    surface: Surface | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


def calibrate(
    path: str | Path,
    answers: Answers | None = None,
    *,
    length: float | None = None,
    tip: Indenter = POINT,
    section: float | None = None,
    youngs_modulus: float | None = None,
) -> Calibration:
    """Read a file and fit the law to it.

    Args:
        length: edge of the object [m], for k.  tip: what pressed it.
        section: of the surface as a beam [m2].  youngs_modulus: [Pa].

    Raises:
        Undecided: the file leaves something open; its questions say what.
        DimpleError: the file cannot be used.
    """
    measurement = read_measurement(path, answers)
    press = prepare(measurement, answers)
    if answers and answers.contact_mm is not None:
        fit, doubt = fit_law(press.depth, press.force, free=press.free), ""
    else:
        fit, doubt = settle(press.depth, press.force, press.free, press.touch)
    depth, force, surface = press.depth - fit.contact.value, press.force - fit.tare, None
    if length is not None:
        surface = surface_constants(depth, force, length, section=section, youngs_modulus=youngs_modulus)
    press = replace(
        press, depth=depth, force=force, back_depth=press.back_depth - fit.contact.value,
        back_force=press.back_force - fit.tare, touch=press.touch + fit.contact.value, tare=press.tare + fit.tare,
    )  # fmt: skip
    return Calibration(
        measurement=measurement, press=press, fit=fit, length=length, tip=tip, surface=surface,
        notes=measurement.notes + press.notes,
        warnings=(*measurement.warnings, *press.warnings, *filter(None, [doubt]), *_doubts(fit, press, length)),
    )  # fmt: skip


def fitted_material(calibration: Calibration, template: Material) -> Material:
    """Return a template material with the calibrated constants; k where it is known.

    Raises:
        DimpleError: a constant is not one of a body.
    """
    fit, k = calibration.fit, calibration.surface and calibration.surface.k
    return replace(template, K1=fit.K1.value, K2=fit.K2.value, x0=fit.x0.value, k=k.value if k else template.k)


def provenance(calibration: Calibration) -> str:
    """Return a line that says where constants come from: file, fit, uncertainty and tip."""
    fit, tip = calibration.fit, calibration.tip
    knee = f"K1 {fit.K1.text(1e3)} N/mm, K2 {fit.K2.text(1e3)} N/mm, x0 {fit.x0.text(1e-3)} mm"
    law = knee if fit.model == "two" else f"one slope {fit.K1.text(1e3)} N/mm"
    return (
        f"{calibration.measurement.source}: {law} (95 %), {fit.rows} rows, "
        f"residual {100 * fit.misfit:.1f} % of {fit.full_scale:.3g} N, {tip.shape} of {1e3 * tip.radius:.3g} mm radius"
    )


def source_of_k(calibration: Calibration) -> str:
    """Return how k was found, with its uncertainty where there is a measured one; "" where it was not."""
    surface = calibration.surface
    if surface is None or surface.k is None:
        return ""
    if surface.paper_k is not None:  # of numbers that were typed in
        return f"k {surface.paper_k / 1e3:.4g} N/mm by Eqs. (9), (10)"
    return f"k {surface.k.text(1e3)} N/mm (95 %) by the force balance"


def _doubts(fit: Fit, press: Press, length: float | None) -> tuple[str, ...]:
    found = []
    deepest = float(press.depth.max())
    if fit.model == "one":
        found.append(
            f"One slope says as much as two (F test p = {fit.knee_p:.2g}): no knee was found down to "
            f"{1e3 * deepest:.3g} mm. K2 equals K1 and x0 is the deepest row."
        )
    elif fit.falls:
        found.append("The best two pieces would fall; these are the best that rise, as a body of the model must.")
    elif fit.K2.value < fit.K1.value:
        found.append(
            "The object softens beyond the knee (K2 < K1). That is unusual: see whether it buckles, and whether the "
            "columns of depth and force are exchanged."
        )
    if fit.misfit > _POOR:
        residual, where = fit.worst
        found.append(
            f"The two-piece law misses the curve by {100 * fit.misfit:.0f} % of full scale (RMS), "
            f"at worst {residual:+.3g} N at {1e3 * where:.3g} mm: the curve has another shape."
        )
    if fit.widened > _WIDENED:
        found.append(
            f"Neighbouring residuals agree with each other (r = {fit.correlation:.2f}): the curve bends where the law "
            f"is straight, by {100 * fit.misfit_before:.0f} % of the force before the knee. The 95 % intervals are "
            f"{fit.widened:.1f} times wider than independent rows would give."
        )
    unknown = [name for name in ("K1", "K2", "x0") if (c := getattr(fit, name)).half_width >= abs(c.value)]
    if unknown:
        found.append(f"The curve does not tell {', '.join(unknown)}: 0 lies within the 95 % interval.")
    if not _DEPTHS[0] < deepest < _DEPTHS[1] or not _FORCES[0] < fit.full_scale < _FORCES[1]:
        found.append(f"{1e3 * deepest:.3g} mm and {fit.full_scale:.3g} N are unlikely for a press: check the units.")
    if length is not None and deepest > length:
        found.append(
            f"The press is {1e3 * deepest:.3g} mm deep, more than the object's {1e3 * length:.3g} mm: check the units."
        )
    if fit.K1.value <= 0:
        found.append("The force does not grow with the depth: there is no material with these constants.")
    return tuple(found)
