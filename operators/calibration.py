"""Calibrations and identifications as Blender keeps them: text in a scene or a material.

As text they are carried along by undo, by files and by presets.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from datetime import date
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core.calibration.calibrate import Calibration
    from ..core.calibration.together import Together
    from ..core.mesh.surface import Mesh

EXTENSIONS = ".csv;.txt;.tsv;.dat;.asc;.tra"
FILTER = ";".join(f"*{ending}" for ending in EXTENSIONS.split(";"))  # of a file browser
POINTS = 160  # of the measured curve that are kept, for the chart
SIMULATED = 40  # and of the simulated one
BEYOND = 1.5  # knees: how deep is pressed where the depth of the measurement is not known
_MEASURED = ("K1", "K2", "x0", "k", "spread_mm", "fill", "tip", "tip_radius_mm")  # what is identified depends on them
# what identified constants can be rescaled by: their names in the core, and the unit in SI
_RESCALED = {"K1": ("K1", 1e3), "K2": ("K2", 1e3), "k": ("k", 1e3), "x0": ("x0", 1e-3), "spread_mm": ("spread", 1e-3)}
SAME_MESH = 1e-3  # share by which area and volume may differ: a body may stand elsewhere, in single precision


@lru_cache(maxsize=32)
def load(text: str) -> dict[str, Any]:
    """Return the record in a kept text, empty where there is none or it is damaged; not to be changed."""
    try:
        record = json.loads(text) if text else {}
    except ValueError:
        return {}
    return record if isinstance(record, dict) else {}


def to_text(calibration: Calibration, advice: Sequence[str] = ()) -> str:
    """Return the text that keeps a calibration: the core's record, and what a chart and a material need of it.

    Args:
        calibration: what was found.
        advice: sentences that follow the warnings.
    """
    from ..core.calibration.identify import NOTICEABLE_FORCE
    from ..core.calibration.record import to_record

    record = to_record(calibration)
    loading, surface = calibration.loading, calibration.surface
    record["warnings"] += advice
    record["date"], record["noticeable"] = date.today().isoformat(), NOTICEABLE_FORCE
    record["provenance"] = f"{record['provenance']}, calibrated {record['date']}"
    record["points"] = thinned(1e3 * loading.depth, loading.force, POINTS)
    record["band"] = band(calibration)
    record["k_to_use"] = surface.k.value / 1e3 if surface and surface.k else None
    record["unusable"] = _unusable(record)
    return json.dumps(record, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def joint_text(first: Calibration, found: Together) -> str:
    """Return the text that keeps a joint fit: as that of its first curve alone, with the constants of all."""
    from ..core.calibration.record import joint_record

    record, joint = load(to_text(first)), joint_record(found)
    said = joint.pop("lines")
    names = ", ".join(each.name for each in found.curves)
    kept = record | joint | {
        "provenance": f"{names}: {said[0]}; {said[1]}, calibrated {record['date']}", "band": [],
        "warnings": [warning for warning in record["warnings"] if found.knee or "knee" not in warning],
        "notes": [*record["notes"], *said[2:]], "source": names,
        "residual_share": max(each.rms for each in found.curves),
    }  # fmt: skip
    return json.dumps(kept | {"unusable": _unusable(kept)}, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def headline(warning: str) -> str:
    """Return what a warning says is wrong, without what it means."""
    return warning.split("\n")[0]


def source(record: dict[str, Any], k: str) -> str:
    """Return the line that a material keeps of where its constants come from; k: where its own does, if so."""
    return f"{record['provenance']}; {k}" if k else record["provenance"]


def band(calibration: Calibration) -> list[list[float]]:
    """Return rows [mm, N, N] of depth and of the ends of the law's 95 % interval there, for the chart."""
    import numpy as np

    fit = calibration.fit
    x = np.linspace(0, calibration.loading.depth.max(), SIMULATED)
    rows = zip(1e3 * x, fit.law(x) - fit.band(x), fit.law(x) + fit.band(x), strict=True)
    return [[float(f"{value:.6g}") for value in row] for row in rows]


def thinned(depth_mm: Any, force: Any, most: int) -> list[list[float]]:
    """Return at most so many rows [mm, N] of a curve, evenly picked."""
    step = max(math.ceil(len(depth_mm) / most), 1)
    pairs = zip(depth_mm[::step].tolist(), force[::step].tolist(), strict=True)
    return [[float(f"{x:.6g}"), float(f"{f:.6g}")] for x, f in pairs]


def deepest(settings: Any, x0: float) -> float:
    """Return how deep [m] a material was measured; where that is not known, as deep as its law has two slopes.

    Args:
        settings: of the material, None where there is none.
        x0: its knee [m].
    """
    measured = load(settings.calibration).get("deepest") if settings else None
    return float(measured) / 1e3 if measured else BEYOND * x0


def fingerprint(settings: Any, mesh: Mesh | None = None) -> dict[str, float | str]:
    """Return everything that the model constants of a material depend on.

    Args:
        settings: of the material: what was measured, with which tip.
        mesh: on which they are identified, wherever it stands; None leaves it out.
    """
    found = {name: getattr(settings, name) for name in _MEASURED}
    if mesh is not None:
        found["vertices"] = len(mesh.rest_positions)
        found["area"], found["volume"] = float(mesh.triangle_areas.sum()), float(mesh.volume)  # [m2], [m3]
    return found


def changed(settings: Any, mesh: Mesh | None = None) -> list[str]:
    """Return what has changed since the model constants of a material were identified: names in `fingerprint`.

    While there are any, the model constants do not hold and an estimate is used instead. They stay in the material, so
    that they hold again when the change is taken back. Constants without a record of an identification always hold.

    Args:
        settings: of the material.
        mesh: that is to be pressed; None asks about the material alone.
    """
    record = load(settings.identification)
    if not record:
        return []
    before = record.get("fingerprint", {})
    return [name for name, value in fingerprint(settings, mesh).items() if not _same(name, value, before.get(name))]


def identification(settings: Any) -> dict[str, Any]:
    """Return the record of a material's identification, empty where there is none or the material has changed."""
    return {} if changed(settings) else load(settings.identification)


def animated(material: Any) -> set[str]:
    """Return the names of what a material is identified from that are keyframed or driven."""
    return {curve.data_path.removeprefix("dimple.") for curve in _curves(material)} & set(_MEASURED)


def identified_for(settings: Any, mesh: Mesh) -> dict[str, float] | None:
    """Return the measured constants that those of the model were identified for, as arguments of `Material`.

    None where there are none, or where another mesh, tip or fill was pressed.
    """
    found = changed(settings, mesh)
    return _in_si(load(settings.identification)["fingerprint"]) if found and set(found) <= set(_RESCALED) else None


def ends_of_keyframes(material: Any) -> list[dict[str, float]]:
    """Return the two keyframes between which a material changes the most, as arguments of `Material`.

    Each has the constants that are keyframed, at its time. There is none where one is driven or no such number.
    """
    moved, names = animated(material), {}
    for curve in _curves(material):
        name = curve.data_path.removeprefix("dimple.")
        if name in moved and (name not in _RESCALED or curve.driver):
            return []
        if name in moved:
            names[name] = curve
    times = sorted({point.co.x for curve in names.values() for point in curve.keyframe_points})
    held = [{name: curve.evaluate(time) for name, curve in names.items()} for time in times]
    if not held or min(min(each.values()) for each in held) <= 0:
        return []

    def far_from(one: dict[str, float]) -> dict[str, float]:
        return max(held, key=lambda each: sum(abs(math.log(each[name] / one[name])) for name in one))

    end = far_from(held[0])
    return [_in_si(end), _in_si(far_from(end))]


def _in_si(values: dict[str, Any]) -> dict[str, float]:
    return {core: unit * float(values[name]) for name, (core, unit) in _RESCALED.items() if name in values}


def _curves(material: Any) -> list[Any]:
    """Return the curves of the keyframes and drivers of a material."""
    moved = material.animation_data if material else None
    if moved is None:
        return []
    strips = [strip for layer in moved.action.layers for strip in layer.strips] if moved.action_slot else []
    bags = [strip.channelbag(moved.action_slot) for strip in strips]
    return [*moved.drivers, *(curve for bag in bags if bag for curve in bag.fcurves)]


def further_constants(text: str) -> dict[str, Any]:
    """Return what a material's identification found besides the constants that it shows, for `ModelConstants`."""
    record = load(text)
    pieces = tuple((float(knee), float(more)) for knee, more in record.get("pieces", ()))
    return {"pieces": pieces, "tension": record.get("tension")}


def _same(name: str, one: float | str, other: float | str | None) -> bool:
    if name in ("area", "volume") and isinstance(one, float) and isinstance(other, (int, float)):
        return abs(one - other) <= SAME_MESH * abs(one)
    return one == other


def _unusable(record: dict[str, Any]) -> str:
    """Return why there is no material with these constants, "" where there is."""
    from ..core.base import DimpleError
    from ..core.material import Material

    k = record["k_to_use"] or 1.0
    try:
        Material(K1=1e3 * record["K1"], K2=1e3 * record["K2"], x0=record["x0"] / 1e3, k=1e3 * k, density=1.0)
    except DimpleError as error:
        return str(error)
    return ""
