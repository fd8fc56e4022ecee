"""Apply the constants of a measured object to the active material."""

from typing import TYPE_CHECKING

import bpy
from bpy.props import StringProperty

from ...core.errors import DimpleError
from ..bridge import sizing
from ..bridge.material_presets import apply, material_of
from ..names import Op
from ..press import polls

if TYPE_CHECKING:
    from ...core.material import Preset


class DIMPLE_OT_apply_preset(polls.Declared, bpy.types.Operator):
    """Give the active object the material and the size of a measured or everyday object"""

    bl_idname = Op.APPLY_PRESET
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(name="Preset", description="Identifier of a preset, such as object_2_vinyl_air")

    needs = polls.needs_mesh, polls.is_own

    def run(self, context: bpy.types.Context) -> None:
        from ...core.everyday_presets import OBJECTS

        preset = next((each for each in OBJECTS if each.name == self.preset), None)
        if preset is None:
            known = ", ".join(each.name for each in OBJECTS)
            raise DimpleError('There is no preset "{preset}". Known presets: {known}.', preset=self.preset, known=known)
        give(context.object, preset)


def give(obj: bpy.types.Object, preset: "Preset") -> None:
    """Make a mesh a soft body with a preset's material, size and sway, and fit fingertip and depth to it."""
    apply(material_of(obj, preset.label).dimple, preset)
    obj.dimple.enabled, obj.dimple.size_mode, obj.dimple.size_mm = True, "CUSTOM", preset.size * 1e3
    obj.dimple.sway, obj.dimple.sway_hz = preset.sway, preset.sway_hz
    sizing.fit(bpy.context.scene, obj)
