"""A calibration as Blender keeps it: text in a scene or a material, so that undo, files and presets carry it along."""

from __future__ import annotations

import json
import math
import re
from datetime import date
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core.calibration.calibrate import Calibration
    from ..core.calibration.question import Undecided

EXTENSIONS = ".csv;.txt;.tsv;.dat;.asc;.tra"
POINTS = 160  # of the measured curve that are kept, for the chart
SIMULATED = 40  # and of the simulated one
BEYOND = 1.35  # knees: how deep is pressed where no measurement says how deep it went


@lru_cache(maxsize=32)
def load(text: str) -> dict[str, Any]:
    """Return what a kept text says, empty where there is none or it is damaged; not to be changed."""
    try:
        told = json.loads(text) if text else {}
    except ValueError:
        return {}
    return told if isinstance(told, dict) else {}


def record(calibration: Calibration) -> str:
    """Return the text that keeps a calibration: the core's report, and what a chart and a material need of it."""
    from ..core.calibration.identify import NOTICEABLE_FORCE
    from ..core.calibration.report import to_json

    told = to_json(calibration)
    press, surface = calibration.press, calibration.surface
    told["date"], told["noticeable"] = date.today().isoformat(), NOTICEABLE_FORCE
    for name in ("notes", "warnings"):
        told[name] = [plain(text) for text in told[name]]
    told["provenance"] = f"{told['provenance']}, calibrated {told['date']}"
    told["points"] = thinned(1e3 * press.depth, press.force, POINTS)
    told["way_back"] = thinned(1e3 * press.back_depth, press.back_force, POINTS // 2)
    told["band"] = band(calibration)
    told["k_to_use"] = surface.k.value / 1e3 if surface and surface.k else None
    told["unusable"] = _unusable(told)
    return json.dumps(told, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def source(told: dict[str, Any], k: str) -> str:
    """Return the line that a material keeps of where its constants come from; k: where its own does, if so."""
    return f"{told['provenance']}, {k}" if k else told["provenance"]


def band(calibration: Calibration) -> list[list[float]]:
    """Return rows [mm, N, N] of depth and of the ends of the law's 95 % interval there, for the chart."""
    import numpy as np

    fit = calibration.fit
    x = np.linspace(0, calibration.press.depth.max(), SIMULATED)
    rows = zip(1e3 * x, fit.law(x) - fit.band(x), fit.law(x) + fit.band(x), strict=True)
    return [[float(f"{value:.6g}") for value in row] for row in rows]


def thinned(depth_mm: Any, force: Any, most: int) -> list[list[float]]:
    """Return at most so many rows [mm, N] of a curve, evenly picked."""
    step = max(math.ceil(len(depth_mm) / most), 1)
    pairs = zip(depth_mm[::step].tolist(), force[::step].tolist(), strict=True)
    return [[float(f"{x:.6g}"), float(f"{f:.6g}")] for x, f in pairs]


def _unusable(told: dict[str, Any]) -> str:
    """Say why there is no material with these constants, "" where there is."""
    from ..core.base import DimpleError
    from ..core.material import Material

    k = told["k_to_use"] or 1.0
    try:
        Material(K1=1e3 * told["K1"], K2=1e3 * told["K2"], x0=told["x0"] / 1e3, k=1e3 * k, density=1.0)
    except DimpleError as error:
        return str(error)
    return ""


def questions(undecided: Undecided) -> str:
    """Return the text of open questions, for the dialog that asks them."""
    from ..core.calibration.report import questions_json

    return json.dumps(questions_json(undecided), ensure_ascii=False)


def plain(message: str) -> str:
    """Return a message of the core in the words of this interface: options are called by their labels."""
    named = re.sub(r"--([a-z]+(?:-[a-z]+)*)", lambda found: f"“{found[1].replace('-', ' ').title()}”", message)
    return named.replace(" Mm”", " (mm)”")


def deepest_mm(settings: Any) -> float:
    """Return how deep [mm] a material was measured; where nobody says, as deep as its law has two slopes."""
    measured = load(settings.calibration).get("deepest")
    return float(measured) if measured else BEYOND * settings.x0
