"""The settings of the poke's fingertip: the tool's header and the sidebar show them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from ...core.poke import PokeState, with_settings
from . import polls

if TYPE_CHECKING:
    Settings = dict[str, float | bool | int]


def settings_of(scene: bpy.types.Scene) -> Settings:
    """Return what a scene says of the fingertip, as `PokeState` names it."""
    stored = scene.dimple
    return {
        "radius": stored.finger_radius_mm / 1e3,
        "depth": stored.press_depth_mm / 1e3,
        "force": stored.press_force_n,
        "by_force": stored.press_by == "FORCE",
        "along_normal": stored.poke_along == "NORMAL",
        "active": stored.active_finger - 1,
    }


def taken(state: PokeState, before: Settings, now: Settings) -> PokeState:
    """Return a state with the settings that changed in the panels; the finger changes only between presses."""
    changed = {name: value for name, value in now.items() if value != before[name]}
    active = int(changed.pop("active", state.active))
    if changed:
        state = with_settings(state, **changed)
    return state if state.pressing else replace(state, active=active)


def help_text(state: PokeState) -> str:
    """Return the help on the keys for the status bar."""
    if state.by_force:
        amount, text = f"{state.force:.3g} N", polls.tip_("Left drag: press with {} | F: radius {} | Ctrl F: force")
    else:
        amount = f"{1e3 * state.depth:.3g} mm"
        text = polls.tip_("Left drag: press {} deep | F: radius {} | Ctrl F: depth")
    keys = (
        polls.tip_("1 2 3: finger"),
        polls.tip_("Space: go on") if state.paused else polls.tip_("Space: pause"),
        polls.tip_("Enter: keep | Esc: leave"),
    )
    return " | ".join((text.format(amount, f"{1e3 * state.radius:.3g} mm"), *keys))
