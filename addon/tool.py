"""The poke as a tool in the toolbar of the viewport, and in the Object menu, where F3 finds it."""

from pathlib import Path

import bpy

from ..operators.names import POKE_TOOL, Op
from ..operators.press.sessions import sessions
from . import cursor
from .drawing import draw_linked


def draw_amount(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw how deep or how hard a press is."""
    if settings.press_by == "DEPTH":
        draw_linked(layout, settings, "press_depth_mm", "depth_follows")
    else:
        layout.prop(settings, "press_force_n")


class DIMPLE_WT_poke(bpy.types.WorkSpaceTool):
    """The tool that starts `dimple.poke` when the left mouse button goes down."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = POKE_TOOL
    bl_label = "Poke"
    bl_description = "Press a soft body with a fingertip and see how it responds"
    bl_icon = str(Path(__file__).with_name("poke_tool"))  # Blender adds .dat; tools/icon.py draws it
    bl_keymap = (
        (Op.POKE, {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        ("wm.radial_control", {"type": "F", "value": "PRESS"}, {"properties": [
            ("data_path_primary", "scene.dimple.finger_radius_mm"), ("zoom_path", "window_manager.dimple.radius_zoom"),
        ]}),
        ("wm.radial_control", {"type": "F", "value": "PRESS", "ctrl": True}, {"properties": [
            ("data_path_primary", "scene.dimple.press_depth_mm"), ("data_path_secondary", "scene.dimple.press_force_n"),
            ("use_secondary", "scene.dimple.by_force"), ("zoom_path", "window_manager.dimple.amount_zoom"),
        ]}),
    )  # fmt: skip

    @staticmethod
    def draw_settings(context: bpy.types.Context, layout: bpy.types.UILayout, _tool: bpy.types.WorkSpaceTool) -> None:
        """Draw the fingertip's settings in the tool header."""
        settings = context.scene.dimple
        draw_linked(layout, settings, "finger_radius_mm", "radius_follows", text="Radius (mm)")
        layout.prop(settings, "press_by", expand=True)
        draw_amount(layout, settings)
        if settings.press_by == "DEPTH":  # a force goes straight into the surface
            layout.prop(settings, "poke_along")
        recording = any(body.recording for body in sessions.values())
        layout.operator(Op.RECORD, text="", icon="REC", depress=recording)

    @staticmethod
    def draw_cursor(context: bpy.types.Context, _tool: bpy.types.WorkSpaceTool, xy: tuple[int, int]) -> None:
        """Draw a circle of the fingertip's size on the body under the mouse."""
        cursor.draw(context, xy)


class DIMPLE_MT_object(bpy.types.Menu):
    """What Dimple does with the selected meshes; the search (F3) looks through menus."""

    bl_label = "Dimple"

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        for verb in (
            Op.MAKE_SOFT, Op.POKE, Op.PLAY, Op.RECORD, Op.RESET, Op.ADD_FINGERTIP, Op.KEY_PRESS, Op.BAKE,
            Op.COMPARE_MATERIALS, Op.USE_MATERIAL,
        ):  # fmt: skip
            layout.operator(verb)


def draw_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Draw Dimple's menu at the end of the Object menu."""
    menu.layout.separator()
    menu.layout.menu("DIMPLE_MT_object")


def register() -> None:
    """Add the tool below Blender's transform tools, and the menu."""
    bpy.utils.register_tool(DIMPLE_WT_poke, after={"builtin.transform"}, separator=True)
    bpy.utils.register_class(DIMPLE_MT_object)
    bpy.types.VIEW3D_MT_object.append(draw_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(draw_menu)
    bpy.utils.unregister_class(DIMPLE_MT_object)
    bpy.utils.unregister_tool(DIMPLE_WT_poke)
