"""Calibrations as they are stored in Blender: as text in a scene or a material.

Undo, files and presets include such text.
"""

from __future__ import annotations

import math
from datetime import date
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ...core.material import NOTICEABLE_FORCE
from ...core.message import Message, from_json, to_json

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
    import numpy as np

    from ...core.calibration.calibrate import to_record

    record = to_record(calibration)
    loading, fit = calibration.loading, calibration.fit
    record["date"], record["noticeable"] = date.today().isoformat(), NOTICEABLE_FORCE
    record["provenance"] = Message(
        "{provenance}, calibrated {date}", provenance=record["provenance"], date=record["date"]
    )
    step, x = math.ceil(len(loading.depth) / POINTS), np.linspace(0, loading.depth.max(), BAND)
    record["points"] = _rounded(1e3 * loading.depth[::step], loading.force[::step])
    record["band"] = _rounded(1e3 * x, fit.law(x) - fit.band(x), fit.law(x) + fit.band(x))
    return to_json(record)


def source(record: dict[str, Any], k: str) -> str:
    """Return the line that states the source of a material's constants; k: the source of its k, or ""."""
    return Message("{provenance}; {k}", provenance=record["provenance"], k=k) if k else record["provenance"]


def _rounded(*columns: Any) -> list[list[float]]:
    return [[float(f"{value:.6g}") for value in row] for row in zip(*columns, strict=True)]
