"""A picture of a calibration, where matplotlib is installed (development only)."""

from __future__ import annotations

from importlib import import_module, util
from pathlib import Path

import numpy as np

from core.base import DimpleError
from core.calibration.calibrate import Calibration


def save_plot(calibration: Calibration, path: str | Path) -> None:
    """Draw loading, unloading and the law with its constants.

    Raises:
        DimpleError: matplotlib is not installed, or the file cannot be written.
    """
    if util.find_spec("matplotlib") is None:
        raise DimpleError("--plot needs matplotlib, which is not installed here. Everything else works without it.")
    figure = import_module("matplotlib.figure").Figure(figsize=(7, 5), layout="constrained")
    axes = figure.add_subplot()
    loading, fit = calibration.loading, calibration.fit
    axes.plot(1e3 * loading.depth, loading.force, ".", ms=3, color="0.55", label="measured")
    if len(loading.unloading_depth) > 8:
        axes.plot(1e3 * loading.unloading_depth, loading.unloading_force, color="0.75", label="unloading")
    x = np.linspace(0, float(loading.depth.max()), 400)
    low, high = fit.law(x) - fit.band(x), fit.law(x) + fit.band(x)
    axes.fill_between(1e3 * x, low, high, color="tab:red", alpha=0.25, lw=0, label="95 % of the law")
    axes.plot(1e3 * x, fit.law(x), color="tab:red", label=_label(calibration))
    axes.set(xlabel="depth x [mm]", ylabel="force F [N]", title=calibration.measurement.source)
    axes.legend(loc="upper left")
    axes.grid(alpha=0.3)
    try:
        figure.savefig(path, dpi=130)
    except (OSError, ValueError) as error:
        raise DimpleError(f"The picture {path} cannot be written: {error}.") from None


def _label(calibration: Calibration) -> str:
    fit = calibration.fit
    if fit.model == "one":
        return f"K = {fit.K1.text(1e3)} N/mm"
    return f"K1 = {fit.K1.text(1e3)}, K2 = {fit.K2.text(1e3)} N/mm, x0 = {fit.x0.text(1e-3)} mm"
