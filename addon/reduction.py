"""The panel on how a body is simulated: the choice, and why."""

import bpy

from ..core.messages import read
from .drawing import draw_notes


class DIMPLE_PT_reduction(bpy.types.Panel):
    """What is simulated in place of the mesh, and why."""

    bl_label = "Speed and Accuracy"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"
    bl_parent_id = "DIMPLE_PT_body"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Show on meshes."""
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the choice and the reason."""
        settings, layout = context.object.dimple, self.layout
        layout.use_property_split = True
        layout.enabled = settings.enabled
        layout.prop(settings, "simulated")
        row = layout.row()
        row.active = settings.simulated == "PROXY"
        row.prop(settings, "proxy_vertices")
        row = layout.row()
        row.active = settings.simulated == "AUTO"
        row.prop(context.scene.dimple, "frame_budget_percent")
        if settings.plan_reason:
            draw_notes(context, layout, [read(settings.plan_reason)])


register, unregister = bpy.utils.register_classes_factory([DIMPLE_PT_reduction])
