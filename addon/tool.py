"""The poke as a tool in the toolbar of the viewport."""

import bpy

from ..operators.names import Op


class DIMPLE_WT_poke(bpy.types.WorkSpaceTool):
    """The tool that starts `dimple.poke` when the left mouse button goes down."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "dimple.poke_tool"
    bl_label = "Poke"
    bl_description = "Press a soft body with a fingertip and see how it responds"
    bl_icon = "ops.transform.push_pull"
    bl_keymap = ((Op.POKE, {"type": "LEFTMOUSE", "value": "PRESS"}, None),)

    @staticmethod
    def draw_settings(context: bpy.types.Context, layout: bpy.types.UILayout, _tool: bpy.types.WorkSpaceTool) -> None:
        """Draw the fingertip's settings in the tool header."""
        settings = context.scene.dimple
        layout.prop(settings, "active_finger")
        layout.prop(settings, "finger_radius_mm")
        layout.prop(settings, "press_by", expand=True)
        layout.prop(settings, "press_force_n" if settings.press_by == "FORCE" else "press_depth_mm")
        layout.prop(settings, "poke_along")


def register() -> None:
    """Add the tool below Blender's transform tools."""
    bpy.utils.register_tool(DIMPLE_WT_poke, after={"builtin.transform"}, separator=True)


def unregister() -> None:
    """Remove the tool."""
    bpy.utils.unregister_tool(DIMPLE_WT_poke)
