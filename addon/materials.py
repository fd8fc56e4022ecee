"""The panels of a material: in Material > Dimple, and in the sidebar, at hand during a poke."""

import bpy

from ..core.errors import DimpleError
from ..core.fills import FILLS
from ..core.material import Material
from ..core.message import Message, read
from ..operators.press.sessions import sessions
from .material_choice import draw_choice
from .my_materials import DIMPLE_PT_material_presets
from .panel_parts import SidebarPanel, draw_notes, draw_pins, shown_if


def wrong_with(settings: bpy.types.PropertyGroup) -> list[str]:
    """Return the core's error message if the constants of a material cannot be used, else nothing."""
    try:
        Material(**settings.to_params())
    except DimpleError as error:
        return [str(error)]
    return []


def draw_softness(context: bpy.types.Context, layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Draw the pictures of the materials, the softness, and errors in the constants."""
    layout.use_property_split = True
    body = context.object
    if body and body.type == "MESH" and body.active_material == material:  # the tab may be pinned to another one
        draw_choice(layout, body)
    layout.prop(material.dimple, "softness_mm")
    draw_notes(context, layout, wrong_with(material.dimple), "ERROR")


def draw_constants(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw the constants, and their source last: it may come and go without moving a field under the mouse."""
    layout.use_property_split = True
    column = layout.column(align=True)
    for name in ("K1", "K2", "x0"):
        column.prop(settings, name)
    column = layout.column(align=True)
    row = column.row(align=True)
    row.active = not settings.spread_mm  # a typed spread replaces k
    row.prop(settings, "k")
    column.prop(settings, "spread_mm", text="Spread (mm)" if settings.spread_mm else "Spread from k (mm)")
    column = layout.column(align=True)
    column.prop(settings, "mass_from")
    column.prop(settings, "density" if settings.mass_from == "DENSITY" else "mass_kg")
    layout.prop(settings, "damping_ratio", slider=True)
    layout.prop(settings, "friction", slider=True)
    layout.prop(settings, "fill")
    if FILLS[settings.fill.lower()].law:
        layout.prop(settings, "pressure_kpa")
    if settings.provenance:
        if settings.edited:
            draw_notes(context, layout, ["The constants were edited and no longer match their source."], "ERROR")
        draw_notes(context, layout, [read(settings.provenance)], "BOOKMARKS")


def draw_sway(context: bpy.types.Context, layout: bpy.types.UILayout, body: bpy.types.Object) -> None:
    """Draw what holds a body, and how it sways."""
    settings, live = body.dimple, sessions.get(body.session_uid)
    column = layout.column(align=True)
    column.enabled = settings.enabled
    draw_pins(column, body)
    column.prop(settings, "sway")
    if settings.sway > 0:
        column.prop(settings, "sway_hz")
        column.prop(settings, "sway_damping")
        if live and not settings.sway_hz and live.session.sway_hz:
            draw_notes(context, layout, [Message("It sways at {hz:.2g} Hz.", hz=live.session.sway_hz)], "INFO")


class WithPresets:
    """A panel with the button of the presets in its header."""

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        DIMPLE_PT_material_presets.draw_panel_header(self.layout)


class DIMPLE_PT_material(WithPresets, bpy.types.Panel):
    """The constants of the active material."""

    bl_label = "Dimple"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    poll = shown_if(lambda context: context.material and not context.material.grease_pencil)

    def draw(self, context: bpy.types.Context) -> None:
        draw_softness(context, self.layout, context.material)
        draw_constants(context, self.layout, context.material.dimple)


class DIMPLE_PT_object_material(WithPresets, SidebarPanel, bpy.types.Panel):
    """The material of the active object."""

    bl_label = "Material"

    poll = shown_if(lambda context: context.object and context.object.type == "MESH")

    def draw(self, context: bpy.types.Context) -> None:
        body, layout = context.object, self.layout
        if body.active_material:
            draw_softness(context, layout, body.active_material)
        else:
            draw_choice(layout, body)
        draw_sway(context, layout, body)


class DIMPLE_PT_object_constants(SidebarPanel, bpy.types.Panel):
    """The measured constants of the active object's material."""

    bl_label = "Constants"
    bl_parent_id = "DIMPLE_PT_object_material"
    bl_options = {"DEFAULT_CLOSED"}

    poll = shown_if(lambda context: DIMPLE_PT_object_material.poll(context) and context.object.active_material)

    def draw(self, context: bpy.types.Context) -> None:
        draw_constants(context, self.layout, context.object.active_material.dimple)


PROPERTIES = (DIMPLE_PT_material,)
SIDEBAR = (DIMPLE_PT_object_material, DIMPLE_PT_object_constants)
