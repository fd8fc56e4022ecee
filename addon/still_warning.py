"""A warning in the dialogs of Blender's own glTF and FBX exporters, which would silently export a bake as a still.

Neither exports a Mesh Cache; FBX does not animate shape keys either with NLA Strips on and All Actions off.
"""

import bpy

from ..operators.bridge.modifiers import is_cache
from ..operators.names import BAKED_KEY
from .panel_parts import draw_notes

EXPORTERS = ("EXPORT_SCENE_OT_gltf", "EXPORT_SCENE_OT_fbx")


def stills(context: bpy.types.Context, exporter: bpy.types.Operator) -> list[str]:
    """Return the names of the objects whose bake an exporter would write as a single pose."""
    if exporter.bl_idname not in EXPORTERS:
        return []
    keys_too = getattr(exporter, "bake_anim_use_nla_strips", False) and not exporter.bake_anim_use_all_actions
    chosen = context.selected_objects if exporter.use_selection else context.scene.objects
    return [obj.name for obj in chosen if obj.type == "MESH" and (_plays_cache(obj) or (keys_too and _plays_keys(obj)))]


def _plays_cache(obj: bpy.types.Object) -> bool:
    return any(is_cache(modifier) and modifier.show_viewport for modifier in obj.modifiers)


def _plays_keys(obj: bpy.types.Object) -> bool:
    keys = obj.data.shape_keys
    return keys is not None and any(key.name.startswith(BAKED_KEY) for key in keys.key_blocks)


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
        draw_notes(context, self.layout, ["The bakes of these objects would be exported as stills:"], "ERROR")
        self.layout.label(text=names, translate=False)
        draw_notes(context, self.layout, ["File > Export > Dimple Animation writes them as they move."], "INFO")


register, unregister = bpy.utils.register_classes_factory([DIMPLE_PT_still_warning])
