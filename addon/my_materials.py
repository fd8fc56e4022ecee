"""The user's own materials, stored as Blender presets."""

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..operators.calibrate.material_file import VALUES
from ..operators.names import Op


class DIMPLE_PT_material_presets(PresetPanel, bpy.types.Panel):
    """The user's own materials."""

    bl_label = "My Materials"
    preset_subdir = "dimple/material"
    preset_operator = "script.execute_preset"
    preset_add_operator = "dimple.material_preset_add"

    def draw(self, context: bpy.types.Context) -> None:
        own = DIMPLE_PT_material_presets
        if bpy.utils.preset_paths(own.preset_subdir):
            PresetPanel.draw(self, context)
        else:  # PresetPanel would report missing paths
            row = self.layout.row()
            row.prop(context.window_manager, "preset_name", text="")
            row.operator(own.preset_add_operator, text="", icon="ADD").name = context.window_manager.preset_name
        self.layout.operator(Op.OPEN_MATERIAL, text="Open File...", icon="IMPORT")
        self.layout.operator(Op.SAVE_MATERIAL, text="Save to File...", icon="EXPORT")


class DIMPLE_OT_material_preset_add(AddPresetBase, bpy.types.Operator):
    """Save these constants as your own material, or remove one"""

    bl_idname = "dimple.material_preset_add"
    bl_label = "Add Material Preset"
    preset_menu = "DIMPLE_PT_material_presets"
    preset_subdir = "dimple/material"
    preset_defines = [
        "material = getattr(bpy.context, 'material', None) or bpy.context.object.active_material",
        "dimple = material.dimple",
    ]
    preset_values = [f"dimple.{name}" for name in VALUES]
