"""The panels of Physics > Dimple: softness, simulation and contact of an object."""

import bpy

from ..core.message import read
from ..operators.names import MAPS, Op
from .panel_parts import draw_notes, draw_pins, draw_prop, shown_if


class PhysicsPanel:
    """A panel in the physics properties of an object."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    poll = shown_if(lambda context: context.object)  # any object has the panels, but only a mesh can be enabled


class DIMPLE_PT_body(PhysicsPanel, bpy.types.Panel):
    """The settings that make the object a soft body."""

    bl_label = "Dimple"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.enabled = context.object.type == "MESH"
        self.layout.prop(context.object.dimple, "enabled", text="")

    def draw(self, context: bpy.types.Context) -> None:
        body, layout = context.object, self.layout
        settings = body.dimple
        layout.use_property_split = True
        if body.type != "MESH":
            draw_notes(context, layout, ["Dimple presses meshes. Make Soft converts this object to one."])
        layout = layout.column()
        layout.enabled = body.type == "MESH" and settings.enabled
        draw_pins(layout, body)
        column = layout.column(align=True)
        for name, _, _ in MAPS:
            column.prop_search(settings, f"{name}_group", body, "vertex_groups")
        column.operator(Op.SOFTNESS_FROM_POKES, text="Softness from Pokes...", icon="IMPORT")
        layout.prop(settings, "size_mode")
        draw_prop(layout, settings, "size_mm", active=settings.size_mode == "CUSTOM")


class DIMPLE_PT_contact(PhysicsPanel, bpy.types.Panel):
    """The contact settings of the object."""

    bl_label = "Contact"
    bl_parent_id = "DIMPLE_PT_body"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.object.dimple, self.layout
        layout.use_property_split = True
        layout.enabled = context.object.type == "MESH"
        hard = settings.collider and not settings.enabled
        layout.prop(settings, "collider")
        draw_prop(layout, settings, "collider_friction", active=hard, slider=True)
        draw_prop(layout, settings, "is_prop", active=hard)
        draw_prop(layout, settings, "prop_mass_kg", active=hard and settings.is_prop)
        draw_prop(layout, settings, "self_contact", active=settings.enabled)


class DIMPLE_PT_reduction(PhysicsPanel, bpy.types.Panel):
    """The choice between mesh and proxy, and its reason."""

    bl_label = "Speed and Accuracy"
    bl_parent_id = "DIMPLE_PT_body"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.object.dimple, self.layout
        layout.use_property_split = True
        layout.enabled = context.object.type == "MESH" and settings.enabled
        layout.prop(settings, "simulated")
        draw_prop(layout, settings, "proxy_vertices", active=settings.simulated == "PROXY")
        draw_prop(layout, context.scene.dimple, "frame_budget_percent", active=settings.simulated == "AUTO")
        if settings.plan_reason:
            draw_notes(context, layout, [read(settings.plan_reason)])


PROPERTIES = (DIMPLE_PT_body, DIMPLE_PT_contact, DIMPLE_PT_reduction)
