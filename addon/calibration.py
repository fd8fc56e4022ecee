"""The calibration panels: fit the law to a file, apply the result to a material, and press virtually."""

from typing import Any

import bpy

from ..operators.calibrate import results
from ..operators.names import Op
from ..operators.translation import translated
from .hand_table import DIMPLE_PT_hand_table
from .panel_parts import SidebarPanel, draw_notes, draw_rows, shown_if
from .readout import iface_


def shown(context: bpy.types.Context) -> tuple[dict, bpy.types.PropertyGroup | None]:
    """Return the calibration to show, and the settings of the material that has it, None if it is not applied yet."""
    if record := results.load(context.scene.dimple.calibration):
        return record, None
    material = context.object.active_material if context.object else None
    settings = material.dimple if material else None
    return (results.load(settings.calibration), settings) if settings else ({}, None)


def rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the rows (label, value with unit) of a calibration; ± gives half the width of the 95 % interval."""
    two = record["model"] == "two"
    lines = [(iface_("Slopes"), iface_("Two") if two else iface_("One"))]
    lines.append(("K1", f"{_with_error(record, 'K1')} N/mm"))
    if two:
        lines.append(("K2", f"{_with_error(record, 'K2')} N/mm"))
        lines.append(("x0", f"{_with_error(record, 'x0')} mm"))
    lines.append((iface_("First Touch"), f"{record['contact']:.4g} mm"))
    lines.append((iface_("Tare"), f"{record['tare']:.3g} N"))
    lines.append((iface_("Measured Range"), f"{record['deepest']:.4g} mm, {record['full_scale']:.4g} N"))
    if k := record["k"]:
        lines.append((iface_("k, Force Balance"), f"{k:.3g} N/mm"))
    if record["damping_ratio_hint"] is not None:
        lines.append((iface_("Hysteresis Loss"), f"{record['loss']:.0%}"))
        lines.append((iface_("Damping Ratio"), f"≈ {record['damping_ratio_hint']:.2f}"))
    lines.append((iface_("Residual"), iface_("{} of full scale").format(f"{record['residual_share']:.1%}")))
    if miss := record.get("largest_error"):
        lines.append((iface_("Largest Error from Points"), f"{miss:.1%}"))
    for role, label in (("depth", "Depth Column"), ("force", "Force Column")):
        if name := record["columns"][role]:
            number, unit = record["column_numbers"][role], record["column_units"][role]
            lines.append((iface_(label), f"{number}: {name}, {unit}"))
    least, most = record["noticeable"]
    return [*lines, (iface_("Just-Noticeable Difference"), f"{least:.0%} – {most:.0%}")]


def headlines(record: dict[str, Any]) -> list[str]:
    """Return the first line of each warning, which states the problem; `sentences` has the explanations."""
    return [translated(warning, iface_).partition("\n")[0] for warning in record["warnings"]]


def sentences(record: dict[str, Any]) -> list[str]:
    """Return the warnings that have an explanation, then the notes of the core."""
    warnings = [translated(each, iface_).replace("\n", " ") for each in record["warnings"] if "\n" in each]
    return [*warnings, *record["notes"]]


def _with_error(record: dict[str, Any], name: str) -> str:
    from ..core.calibration.fit import plus_minus  # imports numpy, so only if there is something to show

    low, high = record[f"{name}_interval"]
    return plus_minus(record[name], (high - low) / 2)


class DIMPLE_PT_calibration(SidebarPanel, bpy.types.Panel):
    """Calibrate from a file, and apply the result to a material."""

    bl_label = "Calibration"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator(Op.CALIBRATE, text="Calibrate from File...", icon="IMPORT")
        record, settings = shown(context)
        if not record:
            draw_notes(context, layout, ["Drop a force-depth file (CSV, text) into the viewport."])
            return
        source = f"{record['source']}, {record['date']}"
        layout.label(text=source, icon="FILE_TEXT", translate=False)
        draw_rows(layout, rows(record))
        draw_notes(context, layout, headlines(record), "ERROR")
        if settings is None:
            row = layout.row(align=True)
            row.operator(Op.APPLY_CALIBRATION, icon="CHECKMARK")
            row.operator(Op.DISCARD_CALIBRATION, text="", icon="X")
        else:
            if settings.edited:
                draw_notes(context, layout, ["The constants were edited and no longer match their source."], "ERROR")
            layout.operator("dimple.material_preset_add", text="Keep as My Material", icon="ADD")


class DIMPLE_PT_calibration_notes(SidebarPanel, bpy.types.Panel):
    """The meaning of the numbers, and how the file was read."""

    bl_label = "Notes"
    bl_parent_id = "DIMPLE_PT_calibration"
    bl_options = {"DEFAULT_CLOSED"}

    poll = shown_if(lambda context: shown(context)[0])

    def draw(self, context: bpy.types.Context) -> None:
        draw_notes(context, self.layout, sentences(shown(context)[0]))


class DIMPLE_PT_virtual_press(SidebarPanel, bpy.types.Panel):
    """Measure the active object by a virtual press."""

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
