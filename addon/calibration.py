"""The panels of calibration: from a file to a result, from there to a material; and a virtual press."""

import bpy

from ..operators.calibrate import results
from ..operators.names import Op
from . import calibrated
from .drawing import SidebarPanel, draw_notes, draw_rows, shown_if
from .hand_table import DIMPLE_PT_hand_table


def shown(context: bpy.types.Context) -> tuple[dict, bpy.types.PropertyGroup | None]:
    """Return the calibration to show, and the settings of its material, None while it has not been applied."""
    if record := results.load(context.scene.dimple.calibration):
        return record, None
    material = context.object.active_material if context.object else None
    settings = material.dimple if material else None
    return (results.load(settings.calibration), settings) if settings else ({}, None)


class DIMPLE_PT_calibration(SidebarPanel, bpy.types.Panel):
    """Calibrating from a file, and applying the result to a material."""

    bl_label = "Calibration"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator(Op.CALIBRATE, text="Calibrate from File...", icon="IMPORT")
        record, settings = shown(context)
        if not record:
            draw_notes(context, layout, ["Drop a force-depth file (CSV, text) into the viewport."])
            return
        layout.label(text=f"{record['source']}, {record['date']}", icon="FILE_TEXT", translate=False)
        draw_rows(layout, calibrated.rows(record))
        draw_notes(context, layout, calibrated.headlines(record), "ERROR")
        if settings is None:
            draw_notes(context, layout, [record["unusable"]] if record["unusable"] else [], "ERROR")
            row = layout.row(align=True)
            row.operator(Op.APPLY_CALIBRATION, icon="CHECKMARK")
            row.operator(Op.DISCARD_CALIBRATION, text="", icon="X")
        else:
            if settings.edited:
                draw_notes(context, layout, ["The constants were edited after the measurement."], "ERROR")
            layout.operator("dimple.material_preset_add", text="Keep as My Material", icon="ADD")


class DIMPLE_PT_calibration_notes(SidebarPanel, bpy.types.Panel):
    """What the numbers mean, and how the file was read."""

    bl_label = "Notes"
    bl_parent_id = "DIMPLE_PT_calibration"
    bl_options = {"DEFAULT_CLOSED"}

    poll = shown_if(lambda context: shown(context)[0])

    def draw(self, context: bpy.types.Context) -> None:
        draw_notes(context, self.layout, calibrated.sentences(shown(context)[0]))


class DIMPLE_PT_virtual_press(SidebarPanel, bpy.types.Panel):
    """Measuring the active object."""

    bl_label = "Virtual Press"
    bl_parent_id = "DIMPLE_PT_calibration"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, body = self.layout, context.object
        layout.use_property_split = True
        if body and body.active_material:
            column = layout.column(align=True)
            column.prop(body.active_material.dimple, "tip")
            column.prop(body.active_material.dimple, "tip_radius_mm")
        layout.prop(context.scene.dimple, "tip_place")
        layout.operator(Op.MEASURE, text="Measure to File...", icon="EXPORT")


SIDEBAR = (DIMPLE_PT_calibration, DIMPLE_PT_calibration_notes, DIMPLE_PT_hand_table, DIMPLE_PT_virtual_press)
