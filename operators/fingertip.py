"""The settings of the poke's fingertip: the tool's header and the sidebar show them, wheel and keys change them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from ..core.poke import PokeState, with_settings
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


def store(scene: bpy.types.Scene, state: PokeState) -> Settings:
    """Let a scene show what wheel and keys have changed; return what it says then."""
    stored = scene.dimple
    stored.finger_radius_mm = state.radius * 1e3
    stored.press_depth_mm, stored.press_force_n = state.depth * 1e3, state.force
    stored.press_by = "FORCE" if state.by_force else "DEPTH"
    stored.active_finger = state.active + 1
    return settings_of(scene)


def taken(state: PokeState, before: Settings, now: Settings) -> PokeState:
    """Return a state with what was changed in the panels since; another finger only between presses."""
    changed = {name: value for name, value in now.items() if value != before[name]}
    active = int(changed.pop("active", state.active))
    if changed:
        state = with_settings(state, **changed)
    return state if state.pressing else replace(state, active=active)


def help_text(state: PokeState, *, recording: bool = False) -> str:
    """Return what the keys do now, for the status bar."""
    if state.by_force:
        amount, text = f"{state.force:.3g} N", polls.tip_("Left drag: press with {} | Ctrl wheel: force | F: by depth")
    else:
        amount = f"{1e3 * state.depth:.3g} mm"
        text = polls.tip_("Left drag: press {} deep | Ctrl wheel: depth | F: by force")
    keys = (
        polls.tip_("Wheel: radius | 1 2 3: finger"),
        polls.tip_("Space: go on") if state.paused else polls.tip_("Space: pause"),
        polls.tip_("R: stop recording") if recording else polls.tip_("R: record"),
        polls.tip_("Enter: keep | Esc: leave"),
    )
    return " | ".join((text.format(amount), *keys))
