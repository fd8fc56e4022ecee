"""The bridge that reads Blender's objects for the core and writes them.

scene_objects reads a body, body_model its materials and pins, final_mesh its surface after all modifiers;
press_modifier is the modifier that shows a press, and write_back keeps one. modifier_kinds classifies a modifier stack,
advice informs the artist, timeline is the clock, bake_files finds and plays bakes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...core.material import Material

in_trial: dict[int, Material] = {}  # by session_uid: the material of a blind trial, instead of the object's own
