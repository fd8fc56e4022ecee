"""What a calibration says in numbers with their errors, and in words: the same in every panel."""

from typing import Any

from .readout import iface_


def rows(told: dict[str, Any]) -> list[tuple[str, str]]:
    """Return (label, value ± half of the 95 % interval with unit) of a calibration."""
    two = told["model"] == "two"
    lines = [(iface_("Slopes"), iface_("Two") if two else iface_("One"))]
    lines.append(("K1", f"{_with_error(told, 'K1')} N/mm"))
    if two:
        lines.append(("K2", f"{_with_error(told, 'K2')} N/mm"))
        lines.append(("x0", f"{_with_error(told, 'x0')} mm"))
    lines.append((iface_("Measured To"), f"{told['deepest']:.4g} mm, {told['full_scale']:.4g} N"))
    lines += _surface(told)
    if told["damping_ratio_hint"] is not None:
        lines.append((iface_("Work Lost"), f"{told['loss']:.0%}"))
        lines.append((iface_("Damping Ratio"), f"≈ {told['damping_ratio_hint']:.2f}"))
    lines.append((iface_("Residual"), iface_("{} of full scale").format(f"{told['residual_share']:.1%}")))
    return [*lines, _hand(told)]


def sentences(told: dict[str, Any]) -> list[str]:
    """Return what k assumes, then what the core noted."""
    ways = [told["k"][way] for way in _WAYS] if told["k"] else []
    return [*(way["assumes"] for way in ways if way["value"] is not None), *told["notes"]]


def noticed(share: float, noticeable: list[float]) -> str:
    """Say what a deviation, a share of the force, is to a hand that can tell a share of a force from here to there."""
    if share < noticeable[0]:
        return iface_("A hand could not tell this from the measurement.")
    if share < noticeable[1]:
        return iface_("A trained hand might just tell this from the measurement.")
    return iface_("A hand can tell this from the measurement.")


def identified(told: dict[str, Any], settings: Any) -> list[tuple[str, str]]:
    """Return (label, value with unit) of an identification."""
    tip = settings.bl_rna.properties["tip"].enum_items[told["tip"].upper()].name
    return [
        (iface_("On"), f"{told['object']}, {told['size']:.4g} mm"),
        (iface_("Vertices"), f"{told['mesh']['vertices']}"),
        (iface_("Tip"), f"{iface_(tip)}, {told['tip_radius']:.3g} mm"),
        (iface_("Pressed To"), f"{told['deepest']:.4g} mm"),
        (iface_("Off, of Full Scale"), f"{told['rms']:.1%}"),
        (iface_("Off at Worst, of the Force"), f"{told['force_off']:.1%}"),
        _hand(told),
        (iface_("Change of Volume"), f"{told['volume_change']:.2%}"),
        ("κ1, κ2", f"{settings.kappa1:.4g}, {settings.kappa2:.4g} N/cm³"),
        ("d0", f"{settings.d0:.4g} mm"),
        (iface_("Share of k"), f"{settings.membrane_scale:.2%}"),
    ]


def identified_sentences(told: dict[str, Any]) -> list[str]:
    """Return what the deviation of the virtual press means to a hand, then what the core noted."""
    return [noticed(told["force_off"], told["noticeable"]), *told["notes"]]


def edited(told: dict[str, Any], settings: Any) -> bool:
    """Tell whether the constants of a material are no longer those of its calibration."""
    return any(abs(getattr(settings, name) - told[name]) > 1e-5 * abs(told[name]) for name in ("K1", "K2", "x0"))


_WAYS = ("equations_9_10", "force_balance")


def _hand(told: dict[str, Any]) -> tuple[str, str]:
    least, most = told["noticeable"]
    return iface_("A Hand Can Tell"), f"{least:.0%} – {most:.0%}"


def _with_error(told: dict[str, Any], name: str) -> str:
    low, high = told[f"{name}_interval"]
    return _plus_minus(told[name], (high - low) / 2)


def _plus_minus(value: float, half_width: float) -> str:
    from ..core.calibration.fit import plus_minus  # with numpy: not before there is something to show

    return plus_minus(value, half_width)


def _surface(told: dict[str, Any]) -> list[tuple[str, str]]:
    if not told["k"]:
        return []
    lines, paper, balance = [], *(told["k"][way] for way in _WAYS)
    if paper["value"] is not None:
        lines.append((iface_("k, Eqs. 9, 10"), f"{paper['value']:.4g} N/mm"))
    if balance["value"] is not None:
        lines.append((iface_("k, Force Balance"), f"{_plus_minus(balance['value'], 1.96 * balance['se'])} N/mm"))
        lines.append((iface_("Tension"), f"{balance['pretension']:.3g} N"))
    return lines
