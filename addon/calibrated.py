"""A calibration and an identification as numbers with their errors, and as sentences: the same in every panel."""

from typing import Any

from .readout import iface_


def rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    """Return (label, value ± half of the 95 % interval with unit) of a calibration."""
    two = record["model"] == "two"
    lines = [(iface_("Slopes"), iface_("Two") if two else iface_("One"))]
    lines.append(("K1", f"{_with_error(record, 'K1')} N/mm"))
    if two:
        lines.append(("K2", f"{_with_error(record, 'K2')} N/mm"))
        lines.append(("x0", f"{_with_error(record, 'x0')} mm"))
    lines.append((iface_("Measured To"), f"{record['deepest']:.4g} mm, {record['full_scale']:.4g} N"))
    lines += _surface(record)
    if record["damping_ratio_hint"] is not None:
        lines.append((iface_("Work Lost"), f"{record['loss']:.0%}"))
        lines.append((iface_("Damping Ratio"), f"≈ {record['damping_ratio_hint']:.2f}"))
    lines.append((iface_("Residual"), iface_("{} of full scale").format(f"{record['residual_share']:.1%}")))
    return [*lines, _hand(record)]


def sentences(record: dict[str, Any]) -> list[str]:
    """Return what k assumes, then the notes of the core."""
    ways = [record["k"][way] for way in _WAYS] if record["k"] else []
    return [*(way["assumes"] for way in ways if way["value"] is not None), *record["notes"]]


def noticed(share: float, noticeable: list[float]) -> str:
    """Return whether a hand can feel an error.

    Args:
        share: the error as a share of the force.
        noticeable: just-noticeable difference as a share of a force: of a trained hand, of any.
    """
    if share < noticeable[0]:
        return iface_("A hand could not tell this from the measurement.")
    if share < noticeable[1]:
        return iface_("A trained hand might just tell this from the measurement.")
    return iface_("A hand can tell this from the measurement.")


def identified(record: dict[str, Any], settings: Any) -> list[tuple[str, str]]:
    """Return (label, value with unit) of an identification."""
    tip = settings.bl_rna.properties["tip"].enum_items[record["tip"].upper()].name
    return [
        (iface_("On"), f"{record['object']}, {record['size']:.4g} mm"),
        (iface_("Vertices"), f"{record['fingerprint']['vertices']}"),
        (iface_("Tip"), f"{iface_(tip)}, {record['tip_radius']:.3g} mm"),
        (iface_("Pressed To"), f"{record['deepest']:.4g} mm"),
        (iface_("RMS Error"), iface_("{} of full scale").format(f"{record['rms']:.1%}")),
        (iface_("Largest Force Error"), f"{record['force_off']:.1%}"),
        _hand(record),
        (iface_("Change of Volume"), f"{record['volume_change']:.2%}"),
        ("κ1, κ2", f"{settings.kappa1:.4g}, {settings.kappa2:.4g} N/cm³"),
        ("d0", f"{settings.d0:.4g} mm"),
        (iface_("Share of k"), f"{settings.membrane_scale:.2%}"),
    ]


def identified_sentences(record: dict[str, Any]) -> list[str]:
    """Return whether a hand can feel the error of the virtual press, then the notes of the core."""
    return [noticed(record["force_off"], record["noticeable"]), *record["notes"]]


def edited(record: dict[str, Any], settings: Any) -> bool:
    """Return whether the constants of a material are no longer those of its calibration."""
    return any(abs(getattr(settings, name) - record[name]) > 1e-5 * abs(record[name]) for name in ("K1", "K2", "x0"))


_WAYS = ("equations_9_10", "force_balance")


def _hand(record: dict[str, Any]) -> tuple[str, str]:
    least, most = record["noticeable"]
    return iface_("Just-Noticeable Difference"), f"{least:.0%} – {most:.0%}"


def _with_error(record: dict[str, Any], name: str) -> str:
    low, high = record[f"{name}_interval"]
    return _plus_minus(record[name], (high - low) / 2)


def _plus_minus(value: float, half_width: float) -> str:
    from ..core.calibration.fit import plus_minus  # with numpy: not before there is something to show

    return plus_minus(value, half_width)


def _surface(record: dict[str, Any]) -> list[tuple[str, str]]:
    if not record["k"]:
        return []
    lines, paper, balance = [], *(record["k"][way] for way in _WAYS)
    if paper["value"] is not None:
        lines.append((iface_("k, Eqs. 9, 10"), f"{paper['value']:.4g} N/mm"))
    if balance["value"] is not None:
        lines.append((iface_("k, Force Balance"), f"{_plus_minus(balance['value'], 1.96 * balance['se'])} N/mm"))
        lines.append((iface_("Tension"), f"{balance['pretension']:.3g} N"))
    return lines
