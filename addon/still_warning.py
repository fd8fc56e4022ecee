"""A warning in the dialogs of Blender's own glTF and FBX exporters, which would silently export a bake as a still."""

import bpy

from ..operators.bridge.modifier_kinds import is_cache
from .panel_parts import draw_notes

EXPORTERS = ("EXPORT_SCENE_OT_gltf", "EXPORT_SCENE_OT_fbx")


def stills(context: bpy.types.Context, exporter: bpy.types.Operator) -> list[str]:
    """Return the names of the objects whose bake an exporter would write as a single pose."""
    if exporter.bl_idname not in EXPORTERS:
        return []
    chosen = context.selected_objects if exporter.use_selection else context.scene.objects
    return [obj.name for obj in chosen if any(is_cache(each) and each.show_viewport for each in obj.modifiers)]


class DIMPLE_PT_still_warning(bpy.types.Panel):
    """The objects whose motion a glTF or FBX file would lack, and how to export it."""

    bl_label = "Dimple"
    bl_space_type = "FILE_BROWSER"
    bl_region_type = "TOOL_PROPS"
    bl_parent_id = "FILE_PT_operator"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        exporter = context.space_data.active_operator
        return exporter is not None and bool(stills(context, exporter))

    def draw(self, context: bpy.types.Context) -> None:
        names = ", ".join(stills(context, context.space_data.active_operator))
        draw_notes(context, self.layout, ["This exporter would write these bakes without their motion:"], "ERROR")
        self.layout.label(text=names, translate=False)
        draw_notes(context, self.layout, ["File > Export > Dimple Animation exports them with their motion."], "INFO")
