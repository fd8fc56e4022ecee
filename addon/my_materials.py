"""The user's own materials, as Blender keeps presets."""

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel


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
            return
        row = self.layout.row()  # Blender would complain of missing paths
        row.prop(context.window_manager, "preset_name", text="")
        row.operator(own.preset_add_operator, text="", icon="ADD").name = context.window_manager.preset_name


class DIMPLE_OT_material_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep these constants as a material of your own, or remove one"""

    bl_idname = "dimple.material_preset_add"
    bl_label = "Add Material Preset"
    preset_menu = "DIMPLE_PT_material_presets"
    preset_subdir = "dimple/material"
    preset_defines = [
        "material = getattr(bpy.context, 'material', None) or bpy.context.object.active_material",
        "dimple = material.dimple",
    ]
    # in this order: constants mark the material as edited, the source clears that, and `edited` is as it was saved
    preset_values = [
        f"dimple.{name}"
        for name in (
            "K1", "K2", "x0", "k", "spread_mm", "mass_from", "density", "mass_kg", "damping_ratio", "friction", "fill",
            "pressure_kpa", "tip", "tip_radius_mm", "calibration", "provenance", "edited",
        )
    ]  # fmt: skip


register, unregister = bpy.utils.register_classes_factory([DIMPLE_PT_material_presets, DIMPLE_OT_material_preset_add])
