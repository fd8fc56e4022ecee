"""Calibrations as they are stored in Blender: as text in a scene or a material.

Undo, files and presets include such text.
"""

from __future__ import annotations

import math
from datetime import date
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ...core.messages import Message, from_json, to_json

if TYPE_CHECKING:
    from ...core.calibration.calibrate import Calibration

EXTENSIONS = ".csv;.txt;.tsv;.dat;.asc;.tra"
FILTER = ";".join(f"*{ending}" for ending in EXTENSIONS.split(";"))  # for a file browser
POINTS = 160  # largest number of points of the measured curve that are stored for the chart
BAND = 40  # number of points of its law's confidence band that are stored for the chart


@lru_cache(maxsize=32)
def load(text: str) -> dict[str, Any]:
    """Return the record in a stored text, empty if there is none or it is damaged; cached, so do not change it."""
    try:
        record = from_json(text) if text else {}
    except ValueError:
        return {}
    return record if isinstance(record, dict) else {}


def to_text(calibration: Calibration) -> str:
    """Return the text that stores a calibration: the core's record, and the data for the chart and the material."""
    from ...core.calibration.calibrate import to_record
    from ...core.material import NOTICEABLE_FORCE

    record = to_record(calibration)
    loading = calibration.loading
    record["date"], record["noticeable"] = date.today().isoformat(), NOTICEABLE_FORCE
    record["provenance"] = Message(
        "{provenance}, calibrated {date}", provenance=record["provenance"], date=record["date"]
    )
    record["points"] = thinned(1e3 * loading.depth, loading.force, POINTS)
    record["band"] = band(calibration)
    return to_json(record)


def band(calibration: Calibration) -> list[list[float]]:
    """Return rows [mm, N, N] of depth and the bounds of the law's 95 % interval there, for the chart."""
    import numpy as np

    fit = calibration.fit
    x = np.linspace(0, calibration.loading.depth.max(), BAND)
    rows = zip(1e3 * x, fit.law(x) - fit.band(x), fit.law(x) + fit.band(x), strict=True)
    return [[float(f"{value:.6g}") for value in row] for row in rows]


def thinned(depth_mm: Any, force: Any, most: int) -> list[list[float]]:
    """Return at most `most` rows [mm, N] of a curve, evenly picked."""
    step = max(math.ceil(len(depth_mm) / most), 1)
    pairs = zip(depth_mm[::step].tolist(), force[::step].tolist(), strict=True)
    return [[float(f"{x:.6g}"), float(f"{f:.6g}")] for x, f in pairs]
