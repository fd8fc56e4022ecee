"""A calibration as JSON and as lines to read."""

from __future__ import annotations

from typing import Any

from .calibrate import Calibration, provenance, source_of_k
from .fit import Constant
from .question import Undecided
from .surface import BALANCE_ASSUMES, PAPER_ASSUMES


def to_json(calibration: Calibration) -> dict[str, Any]:
    """Return what a program wants to know; slopes in N/mm, depths in mm, forces in N."""
    c, fit, press = calibration, calibration.fit, calibration.press
    two = fit.model == "two"
    report: dict[str, Any] = {
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
        "knee": {"f_test_p": fit.knee_p, "bic_gain": fit.knee_bic},
        "residual_rms": fit.noise,
        "residual_share": fit.misfit,
        "residual_correlation": fit.correlation,
        "full_scale": fit.full_scale,
        "deepest": press.depth.max() * 1e3,
        "rows": fit.rows,
        "contact": press.touch * 1e3,
        "contact_se": fit.contact.error * 1e3 or None,
        "tare": press.tare,
        "cycle": press.cycle,
        "cycles": press.cycles,
        "loss": press.loss,
        "damping_ratio_hint": press.damping_ratio,
        "columns": {"depth": c.measurement.depth_header, "force": c.measurement.force_header},
        "tip": c.tip.shape,
        "tip_radius": c.tip.radius * 1e3,
        "length": None if c.length is None else c.length * 1e3,
        "k": None,
        "provenance": provenance(c),
        "source_of_k": source_of_k(c),
        "notes": list(c.notes),
        "warnings": list(c.warnings),
    }
    if c.surface is not None:
        balance = c.surface.balance_k
        report["k"] = {
            "equations_9_10": {
                "value": None if c.surface.paper_k is None else c.surface.paper_k / 1e3, "assumes": PAPER_ASSUMES,
            },
            "force_balance": {
                "value": balance and balance.value / 1e3, "se": balance and balance.error / 1e3,
                "pretension": c.surface.pretension, "assumes": BALANCE_ASSUMES,
            },
        }  # fmt: skip
    return report


def to_lines(calibration: Calibration) -> list[str]:
    """Return what a person wants to read."""
    c, fit = calibration, calibration.fit
    slopes = "two slopes" if fit.model == "two" else "one slope"
    lines = [f"{c.measurement.source}: {slopes} through {fit.rows} rows up to {fit.full_scale:.4g} N"]
    lines.append(f"  K1 = {fit.K1.text(1e3)} N/mm (95 %)")
    lines.append(f"  K2 = {fit.K2.text(1e3)} N/mm")
    lines.append(f"  x0 = {fit.x0.text(1e-3)} mm")
    lines.append(f"  residual {100 * fit.misfit:.2f} % of full scale (RMS)")
    if c.press.damping_ratio is not None:
        lost = 100 * (c.press.loss or 0)
        lines.append(f"  {lost:.0f} % of the work is lost: damping ratio about {c.press.damping_ratio:.2f}")
    if c.surface is not None:
        if c.surface.paper_k is not None:
            lines.append(f"  k = {c.surface.paper_k / 1e3:.4g} N/mm. {PAPER_ASSUMES}")
        else:
            lines.append("  k by Eqs. (9), (10) needs --section-mm2 and --youngs-modulus-mpa: it is 2 A E / l.")
        if c.surface.balance_k is not None and c.surface.pretension is not None:
            k = f"{c.surface.balance_k.text(1e3)} N/mm over {c.surface.pretension:.3g} N of tension"
            lines.append(f"  k = {k}. {BALANCE_ASSUMES}")
    lines += [f"  Note: {note}" for note in c.notes]
    lines += [f"  Warning: {warning}" for warning in c.warnings]
    return lines


def questions_json(undecided: Undecided) -> dict[str, Any]:
    """Return open questions with the options that answer them."""
    return {
        "questions": [
            {
                "name": question.name, "text": question.text, "option": question.option,
                "candidates": [{"value": c.value, "label": c.label} for c in question.candidates],
            }
            for question in undecided.questions
        ]
    }  # fmt: skip


def _interval(constant: Constant, per: float) -> list[float]:
    return [(constant.value - constant.half_width) / per, (constant.value + constant.half_width) / per]
