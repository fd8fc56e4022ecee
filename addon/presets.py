"""Material presets: the measured objects of the paper, and the user's own."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..operators.names import Op

if TYPE_CHECKING:
    from ..core.material import Preset


class DIMPLE_PT_material_presets(PresetPanel, bpy.types.Panel):
    """The measured objects of the paper, then the user's own materials."""

    bl_label = "Materials"
    preset_subdir = "dimple/material"
    preset_operator = "script.execute_preset"
    preset_add_operator = "dimple.material_preset_add"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the measured objects above Blender's own list of presets."""
        from ..core.everyday import EVERYDAY, MADE_UP  # not at import: numpy, and enabling must be quick
        from ..core.material import PRESETS

        column = self.layout.column(align=True)
        column.label(text="Measured Objects")
        draw_presets(column, PRESETS)
        column.label(text="From Rules and Data Sheets")
        draw_presets(column, [preset for preset in EVERYDAY if not preset.provenance.startswith(MADE_UP)])
        column.label(text="Made Up")
        draw_presets(column, [preset for preset in EVERYDAY if preset.provenance.startswith(MADE_UP)])
        self.layout.label(text="My Materials")
        own = DIMPLE_PT_material_presets
        if bpy.utils.preset_paths(own.preset_subdir):
            PresetPanel.draw(self, context)
            return
        row = self.layout.row()  # Blender would complain of missing paths
        row.prop(context.window_manager, "preset_name", text="")
        row.operator(own.preset_add_operator, text="", icon="ADD").name = context.window_manager.preset_name


def draw_presets(column: bpy.types.UILayout, presets: "Sequence[Preset]") -> None:
    """Draw a button for each preset."""
    for preset in presets:
        column.operator(Op.APPLY_PRESET, text=preset.label, icon="MATERIAL").preset = preset.name


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
