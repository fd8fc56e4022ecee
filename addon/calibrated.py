"""The results of calibration as rows and notes, the same in every panel."""

from typing import Any

from ..operators.translation import translated
from .readout import iface_


def rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    """Return (label, value with unit) of a calibration; ± is half of the 95 % interval."""
    two = record["model"] == "two"
    lines = [(iface_("Slopes"), iface_("Two") if two else iface_("One"))]
    lines.append(("K1", f"{_with_error(record, 'K1')} N/mm"))
    if two:
        lines.append(("K2", f"{_with_error(record, 'K2')} N/mm"))
        lines.append(("x0", f"{_with_error(record, 'x0')} mm"))
    lines.append((iface_("First Touch"), f"{record['contact']:.4g} mm"))
    lines.append((iface_("Tare"), f"{record['tare']:.3g} N"))
    lines.append((iface_("Measured Range"), f"{record['deepest']:.4g} mm, {record['full_scale']:.4g} N"))
    if k := record["k"]:
        lines.append((iface_("k, Force Balance"), f"{_plus_minus(k['value'], k['half_width'])} N/mm"))
        lines.append((iface_("Pretension"), f"{k['pretension']:.3g} N"))
    if record["damping_ratio_hint"] is not None:
        lines.append((iface_("Hysteresis Loss"), f"{record['loss']:.0%}"))
        lines.append((iface_("Damping Ratio"), f"≈ {record['damping_ratio_hint']:.2f}"))
    lines.append((iface_("Residual"), iface_("{} of full scale").format(f"{record['residual_share']:.1%}")))
    if miss := record.get("largest_error"):
        lines.append((iface_("Largest Error from Points"), f"{miss:.1%}"))
    if units := record.get("column_units"):
        for role, label in (("depth", "Depth Column"), ("force", "Force Column")):
            number = record["column_numbers"][role]
            lines.append((iface_(label), f"{number}: {record['columns'][role]}, {units[role]}"))
    return [*lines, _noticeable(record)]


def headlines(record: dict[str, Any]) -> list[str]:
    """Return what the warnings say is wrong; what they mean is among the sentences."""
    return [translated(warning, iface_).partition("\n")[0] for warning in record["warnings"]]


def sentences(record: dict[str, Any]) -> list[str]:
    """Return the warnings that have more to say, what the values of k assume, then the notes of the core."""
    warnings = [translated(each, iface_).replace("\n", " ") for each in record["warnings"] if "\n" in each]
    return [*warnings, *([record["k"]["assumes"]] if record["k"] else []), *record["notes"]]


def _noticeable(record: dict[str, Any]) -> tuple[str, str]:
    least, most = record["noticeable"]
    return iface_("Just-Noticeable Difference"), f"{least:.0%} – {most:.0%}"


def _with_error(record: dict[str, Any], name: str) -> str:
    low, high = record[f"{name}_interval"]
    return _plus_minus(record[name], (high - low) / 2)


def _plus_minus(value: float, half_width: float) -> str:
    from ..core.calibration.fit import plus_minus  # with numpy: not before there is something to show

    return plus_minus(value, half_width)
