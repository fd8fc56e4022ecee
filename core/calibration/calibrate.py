"""From a file to constants: reading, preparing and fitting as one, with all that was found on the way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from .contact import settle
from .fit import Fit, fit_law
from ..material import POINT, Indenter
from .prepare import LoadingCurve, prepare
from .question import Answers
from .reader import Measurement, read_measurement
from .surface import Surface, surface_constants

_POOR = 0.05  # of full scale, RMS: a law that misses the curve by more gets a warning
_WIDENED = 2.0  # times wider intervals are explained
_DEPTHS, _FORCES = (2e-5, 0.5), (1e-3, 2e4)  # [m], [N]: presses outside have the wrong unit more often than not


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """What a file says about an object, and how it was read.

    measurement: the file as it was read.
    loading: its loading curve, from the first touch as fitted.
    fit: the law and its constants.
    length: edge of the object [m], None where it is not known.
    tip: what pressed it.
    surface: k both ways, None without a length.
    notes: messages about how the file was read.
    warnings: messages about what may be wrong.
    unsure: fields of Answers that were found, but might be otherwise.
    """

    measurement: Measurement
    loading: LoadingCurve
    fit: Fit
    length: float | None
    tip: Indenter
    surface: Surface | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    unsure: tuple[str, ...]


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
        path: of a force-depth file.
        answers: of the user to earlier questions.
        length: edge of the object [m], for k.
        tip: what pressed it.
        section: of the surface as a beam [m2].
        youngs_modulus: of the surface [Pa].

    Raises:
        Undecided: the file leaves something open; its questions say what.
        DimpleError: the file cannot be used.
    """
    measurement = read_measurement(path, answers)
    loading, doubt = prepare(measurement, answers), ""
    if answers and answers.contact_mm is not None:
        fit = fit_law(loading.depth, loading.force, free=loading.free)
    else:
        fit, doubt = settle(loading.depth, loading.force, loading.free, loading.touch)
    loading = _from_the_touch(loading, fit)
    surface = None
    if length is not None:
        surface = surface_constants(
            loading.depth, loading.force, length, section=section, youngs_modulus=youngs_modulus
        )  # fmt: skip
    return Calibration(
        measurement=measurement,
        loading=loading,
        fit=fit,
        length=length,
        tip=tip,
        surface=surface,
        notes=measurement.notes + loading.notes,
        warnings=(*measurement.warnings, *loading.warnings, *_doubts(fit, loading, length), *filter(None, [doubt])),
        unsure=("contact_mm",) if doubt else (),
    )


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


def _from_the_touch(loading: LoadingCurve, fit: Fit) -> LoadingCurve:
    """Return a loading curve whose depth and force begin at the first touch as fitted."""
    contact, tare = fit.contact.value, fit.tare
    return replace(
        loading,
        depth=loading.depth - contact,
        force=loading.force - tare,
        unloading_depth=loading.unloading_depth - contact,
        unloading_force=loading.unloading_force - tare,
        touch=loading.touch + contact,
        tare=loading.tare + tare,
    )


def _doubts(fit: Fit, loading: LoadingCurve, length: float | None) -> tuple[str, ...]:
    found = []
    deepest = float(loading.depth.max())
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
        found.append(f"The curve does not determine {', '.join(unknown)}: 0 lies within the 95 % interval.")
    if not _DEPTHS[0] < deepest < _DEPTHS[1] or not _FORCES[0] < fit.full_scale < _FORCES[1]:
        found.append(f"{1e3 * deepest:.3g} mm and {fit.full_scale:.3g} N are unlikely for a press: check the units.")
    if length is not None and deepest > length:
        found.append(
            f"The press is {1e3 * deepest:.3g} mm deep, more than the object's {1e3 * length:.3g} mm: check the units."
        )
    if fit.K1.value <= 0:
        found.append("The force does not grow with the depth: there is no material with these constants.")
    return tuple(found)
