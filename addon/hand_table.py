"""The table of a press measured by hand: its properties in the scene, and its panel."""

import bpy
from bpy.props import FloatProperty, FloatVectorProperty

from ..operators.names import Op
from .object_settings import FIXED
from .panel_parts import SidebarPanel, draw_notes

ROWS = 32  # largest size of a vector property in Blender
SHOWN = 8  # rows that an empty table shows


class HandTable:
    """The properties of the table in a scene; rows without grams are empty, except the touch at depth 0."""

    hand_step_mm: FloatProperty(
        name="One Step (mm)",
        description="Depth of one step in the table: 1 if steps are millimeters, the pitch of the screw if they are "
                    "its turns (M5: 0.8), the thickness of a coin if they are stacked coins",
        default=1.0, min=0.01, soft_max=10.0, **FIXED,
    )  # fmt: skip
    hand_depths: FloatVectorProperty(
        name="Depth", description="Steps below the touch", size=ROWS, default=tuple(range(ROWS)), min=0.0, precision=2,
        **FIXED,
    )  # fmt: skip
    hand_grams: FloatVectorProperty(
        name="Grams", description="Reading of the scale at this depth", size=ROWS, min=0.0, precision=1, **FIXED
    )


class DIMPLE_PT_hand_table(SidebarPanel, bpy.types.Panel):
    """Measure with a kitchen scale."""

    bl_label = "Measure by Hand"
    bl_parent_id = "DIMPLE_PT_calibration"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, table = self.layout, context.scene.dimple
        draw_notes(context, layout, [
            "Put the object on a kitchen scale, touch it from above with the tip, and set the scale to 0. Then press "
            "it step by step, and note the grams.",
        ])  # fmt: skip
        layout.prop(table, "hand_step_mm")
        filled = max((i for i, grams in enumerate(table.hand_grams) if grams), default=0)
        column = layout.column(align=True)
        row = column.row(align=True)
        row.label(text="Steps")
        row.label(text="Grams")
        for i in range(min(max(filled + 3, SHOWN), ROWS)):
            row = column.row(align=True)
            row.prop(table, "hand_depths", index=i, text="")
            row.prop(table, "hand_grams", index=i, text="")
        row = layout.row(align=True)
        row.operator(Op.PASTE_TABLE, icon="PASTEDOWN")
        row.operator(Op.CALIBRATE_BY_HAND, icon="CHECKMARK")
