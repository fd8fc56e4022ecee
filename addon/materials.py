"""The constants of a material: Material > Dimple, and at hand in the sidebar while one pokes."""

import bpy

from .drawing import MaterialPanel, SidebarPanel, draw_notes
from .presets import DIMPLE_PT_material_presets


def wrong_with(settings: bpy.types.PropertyGroup) -> list[str]:
    """Return the message of the core on why the constants of a material cannot be used, if so."""
    from ..core.base import DimpleError  # not at import: it needs numpy, and enabling must be quick
    from ..core.material import Material

    try:
        Material(**settings.to_params())
    except DimpleError as error:
        return [str(error)]
    return []


def draw_law(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw the constants of force against depth."""
    layout.use_property_split = True
    column = layout.column(align=True)
    for name in ("K1", "K2", "x0"):
        column.prop(settings, name)


def draw_others(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw the other constants."""
    layout.use_property_split = True
    column = layout.column(align=True)
    row = column.row(align=True)
    row.active = not settings.spread_mm  # a spread that is typed takes its place
    row.prop(settings, "k")
    column.prop(settings, "spread_mm", text="Spread (mm)" if settings.spread_mm else "Spread from k (mm)")
    column = layout.column(align=True)
    column.prop(settings, "mass_from")
    column.prop(settings, "density" if settings.mass_from == "DENSITY" else "mass_kg")
    layout.prop(settings, "damping_ratio", slider=True)
    layout.prop(settings, "friction", slider=True)
    layout.prop(settings, "fill")
    if settings.fill != "NONE":
        layout.prop(settings, "pressure_kpa")


class DIMPLE_PT_material(MaterialPanel, bpy.types.Panel):
    """The constants of the active material."""

    bl_label = "Dimple"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Show on every material of a mesh."""
        return context.material is not None and not context.material.grease_pencil

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """Draw the button of the presets."""
        DIMPLE_PT_material_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the constants, then their source and what is wrong: no field moves away under the mouse."""
        settings, layout = context.material.dimple, self.layout
        draw_law(layout, settings)
        draw_others(layout, settings)
        draw_notes(context, layout, wrong_with(settings), "ERROR")
        if settings.provenance:
            if settings.edited:
                draw_notes(context, layout, ["The constants were edited after the measurement."], "ERROR")
            draw_notes(context, layout, [settings.provenance], "BOOKMARKS")


class _ObjectMaterialPanel(SidebarPanel):
    """A panel of the active object's material in the sidebar."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a mesh with a material."""
        body = context.object
        return body is not None and body.type == "MESH" and body.active_material is not None


class DIMPLE_PT_object_material(_ObjectMaterialPanel, bpy.types.Panel):
    """The law of the active object's material, above what grows while one pokes."""

    bl_label = "Material"
    bl_parent_id = "DIMPLE_PT_session"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the constants, then what is wrong."""
        settings = context.object.active_material.dimple
        draw_law(self.layout, settings)
        draw_notes(context, self.layout, wrong_with(settings), "ERROR")


class DIMPLE_PT_object_material_others(_ObjectMaterialPanel, bpy.types.Panel):
    """The other constants of the active object's material."""

    bl_label = "Other Constants"
    bl_parent_id = "DIMPLE_PT_object_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw them."""
        draw_others(self.layout, context.object.active_material.dimple)


PROPERTIES = (DIMPLE_PT_material,)
SIDEBAR = (DIMPLE_PT_object_material, DIMPLE_PT_object_material_others)
