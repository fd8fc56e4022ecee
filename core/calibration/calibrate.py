"""From a file to constants: reading, preparing and fitting in one call, and the result as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..material import POINT, Indenter, law_force, law_power
from ..message import Message
from .doubts import Miss, doubts, largest_miss
from .fit import Fit, fit_law
from .known_words_and_units import UNITS
from .measurement import Measurement, read_measurement
from .press import LoadingCurve, prepare
from .question import Answers
from .surface_constant import ASSUMES, surface_constant
from .touch import settle


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """The constants of an object from a file, and how the file was read.

    measurement: the file as it was read.
    loading: its loading curve, with depths from the fitted first touch.
    fit: the law and its constants.
    length: edge of the object [m], None if unknown.
    tip: the indenter.
    k: constant of the surface's springs [N/m], None without a length.
    miss: largest error of the law at the measured points, None if no force was measured.
    notes: messages about how the file was read.
    warnings: messages about what may be wrong: a headline, and after a line break what it means.
    """

    measurement: Measurement
    loading: LoadingCurve
    fit: Fit
    length: float | None
    tip: Indenter
    k: float | None
    miss: Miss | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


def calibrate(
    path: str | Path, answers: Answers | None = None, *, length: float | None = None, tip: Indenter = POINT
) -> Calibration:
    """Read a file and fit the law to it.

    Args:
        path: a force-depth file.
        answers: the user's answers to earlier questions.
        length: edge of the object [m], for k.
        tip: the indenter.

    Raises:
        Undecided: the file is ambiguous; the questions of the exception ask what it leaves open.
        DimpleError: the file cannot be used.
    """
    measurement = read_measurement(path, answers)
    loading, fit = settle(prepare(measurement, answers), answers)
    return _calibration(measurement, loading, fit, length, tip)


def calibrate_by_hand(
    depth: Sequence[float], weight: Sequence[float], *, length: float | None = None, tip: Indenter = POINT
) -> Calibration:
    """Fit the law to a few readings of a scale, noted by hand; the tare is the mean reading at depth 0, if any.

    Args:
        depth: (n,) from the touch [mm].
        weight: (n,) readings of the scale [g].
        length: edge of the object [m], for k.
        tip: the indenter.

    Raises:
        DimpleError: too few rows.
    """
    order = np.argsort(depth, kind="stable")
    x, f = 1e-3 * np.asarray(depth, np.float64)[order], UNITS["gf"][1] * np.asarray(weight, np.float64)[order]
    tare = float(f[x <= 0].mean()) if (x <= 0).any() else 0.0
    fit, none = fit_law(x, f, tare=tare), np.empty(0)
    loading = LoadingCurve(depth=x, force=f, unloading_depth=none, unloading_force=none, inward=1).begun_at(0.0, tare)
    measurement = Measurement(
        source="Measured by Hand", depth=x, force=f, depth_header="", force_header="", units=("mm", "gf")
    )
    return _calibration(measurement, loading, fit, length, tip)


def _calibration(
    measurement: Measurement, loading: LoadingCurve, fit: Fit, length: float | None, tip: Indenter
) -> Calibration:
    miss = largest_miss(loading.depth, loading.force, fit.law(loading.depth))
    read, prepared = measurement.remarks, loading.remarks
    k = None if length is None else surface_constant(loading.depth, loading.force, length)
    return Calibration(
        measurement=measurement, loading=loading, fit=fit, length=length, tip=tip, k=k, miss=miss,
        notes=(*read.notes, *prepared.notes, *([ASSUMES] if k else [])),
        warnings=(*read.warnings, *prepared.warnings, *doubts(fit, loading, miss, _as_solid(fit, loading, tip))),
    )  # fmt: skip


def _as_solid(fit: Fit, loading: LoadingCurve, tip: Indenter) -> Miss | None:
    """Return the largest error of a solid's law with the fitted constants, None if it is the same two-slope law."""
    law = fit.K1.value, fit.K2.value, fit.x0.value
    power = law_power(*law[:2], "solid", tip.shape)
    if power == 1:
        return None
    forces = np.array([law_force(depth, *law, power) for depth in loading.depth.tolist()])
    return largest_miss(loading.depth, loading.force, forces)


def provenance(calibration: Calibration) -> str:
    """Return a line that states the origin of the constants: file, fit, uncertainty and tip."""
    fit, tip = calibration.fit, calibration.tip
    knee = f"K1 {fit.K1.text(1e3)} N/mm, K2 {fit.K2.text(1e3)} N/mm, x0 {fit.x0.text(1e-3)} mm"
    law = knee if fit.model == "two" else Message("one slope {K1} N/mm", K1=fit.K1.text(1e3))
    return Message(
        "{source}: {law} (95 %), {rows} rows, residual {misfit:.1f} % of {full_scale:.3g} N, {tip} of {radius:.3g} "
        "mm radius",
        source=Message(calibration.measurement.source),
        law=law,
        rows=fit.rows,
        misfit=100 * fit.misfit,
        full_scale=fit.full_scale,
        tip=Message(tip.shape),
        radius=1e3 * tip.radius,
    )


def source_of_k(calibration: Calibration) -> str:
    """Return k and how it was found; "" if it was not found."""
    return Message("k {k} N/mm by the force balance", k=f"{calibration.k / 1e3:.3g}") if calibration.k else ""


def to_record(calibration: Calibration) -> dict[str, Any]:
    """Return a calibration as plain data for JSON: slopes in N/mm, depths in mm, forces in N."""
    c, fit, loading, m = calibration, calibration.fit, calibration.loading, calibration.measurement
    record: dict[str, Any] = {"source": m.source, "model": fit.model}
    for name, unit in (("K1", 1e3), ("K2", 1e3), ("x0", 1e-3)):
        constant = getattr(fit, name)
        ends = [(constant.value + sign * constant.half_width) / unit for sign in (-1, 1)]
        record |= {name: constant.value / unit, f"{name}_se": constant.error / unit, f"{name}_interval": ends}
    return record | {
        "residual_share": fit.misfit,
        "full_scale": fit.full_scale,
        "deepest": loading.depth.max() * 1e3,
        "largest_error": c.miss and c.miss.share,
        "contact": loading.reading(0.0),
        "tare": loading.tare,
        "loss": loading.loss,
        "damping_ratio_hint": loading.damping_ratio,
        "columns": {"depth": m.depth_header, "force": m.force_header},
        "column_numbers": {"depth": m.columns[0], "force": m.columns[1]},
        "column_units": {"depth": m.units[0], "force": m.units[1]},
        "tip": c.tip.shape,
        "tip_radius": c.tip.radius * 1e3,
        "length": None if c.length is None else c.length * 1e3,
        "k": c.k and c.k / 1e3,
        "provenance": provenance(c),
        "source_of_k": source_of_k(c),
        "notes": list(c.notes),
        "warnings": list(c.warnings),
    }
