"""A calibration as plain data, as it is kept in a file: slopes in N/mm, depths in mm, forces in N."""

from __future__ import annotations

from typing import Any

from .calibrate import Calibration, provenance, source_of_k
from .doubts import Miss
from .fit import Constant
from .surface import BALANCE_ASSUMES, PAPER_ASSUMES


def to_record(calibration: Calibration) -> dict[str, Any]:
    """Return constants with their errors, what was read on the way, and the messages; JSON can hold it."""
    c, fit, loading = calibration, calibration.fit, calibration.loading
    two = fit.model == "two"
    return {
        "source": c.measurement.source,
        "model": fit.model,
        "K1": fit.K1.value / 1e3,
        "K2": fit.K2.value / 1e3,
        "x0": fit.x0.value * 1e3,
        "K1_se": fit.K1.error / 1e3,
        "K2_se": fit.K2.error / 1e3,
        "x0_se": fit.x0.error * 1e3 if two else None,
        "K1_interval": _interval(fit.K1, 1e3),
        "K2_interval": _interval(fit.K2, 1e3),
        "x0_interval": _interval(fit.x0, 1e-3) if two else None,
        "units": {"K1": "N/mm", "K2": "N/mm", "x0": "mm", "k": "N/mm", "force": "N", "interval": "95 %"},
        "knee": {"bic_gain": fit.knee_bic},
        "residual_rms": fit.noise,
        "residual_share": fit.misfit,
        "residual_correlation": fit.correlation,
        "full_scale": fit.full_scale,
        "deepest": loading.depth.max() * 1e3,
        "rows": fit.rows,
        "largest_error": _miss(c.miss),
        "contact": loading.reading(0.0),
        "contact_se": fit.contact.error * 1e3 or None,
        "tare": loading.tare,
        "cycle": loading.cycle,
        "cycles": loading.cycles,
        "loss": None if loading.loss is None else max(loading.loss, 0.0),
        "damping_ratio_hint": loading.damping_ratio,
        "columns": {"depth": c.measurement.depth_header, "force": c.measurement.force_header},
        "column_numbers": {"depth": c.measurement.columns[0], "force": c.measurement.columns[1]},
        "column_units": {"depth": c.measurement.units[0], "force": c.measurement.units[1]},
        "tip": c.tip.shape,
        "tip_radius": c.tip.radius * 1e3,
        "length": None if c.length is None else c.length * 1e3,
        "k": _surface(c),
        "provenance": provenance(c),
        "source_of_k": source_of_k(c),
        "notes": list(c.notes),
        "warnings": list(c.warnings),
    }


def _miss(miss: Miss | None) -> dict[str, float] | None:
    """Return the largest error of the law against the measured points: a share of the force, [N], [mm]."""
    return None if miss is None else {"share": miss.share, "error": miss.error, "depth": 1e3 * miss.depth}


def _surface(c: Calibration) -> dict[str, Any] | None:
    """Return k [N/mm] both ways, None where the object's length is not known."""
    if c.surface is None:
        return None
    paper, balance = c.surface.paper_k, c.surface.balance_k
    return {
        "equations_9_10": {"value": None if paper is None else paper / 1e3, "assumes": PAPER_ASSUMES},
        "force_balance": {
            "value": balance and balance.value / 1e3, "se": balance and balance.error / 1e3,
            "pretension": c.surface.pretension, "assumes": BALANCE_ASSUMES,
        },
    }  # fmt: skip


def _interval(constant: Constant, per: float) -> list[float]:
    return [(constant.value - constant.half_width) / per, (constant.value + constant.half_width) / per]
