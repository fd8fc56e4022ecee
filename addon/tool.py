"""The poke as a tool in the toolbar of the viewport, and in the Object menu, where F3 finds it.

The circle under the mouse has the size of the fingertip and lies on the body that a click would press.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ..operators.names import POKE_TOOL, Op
from . import canvas, shapes

if TYPE_CHECKING:
    from ..operators.press.poke_input import View

PIXELS_PER_NEWTON = 20.0  # scale of the control that changes a force: 5 N give a circle that is easy to drag
_pixels = [5.0]  # [px/mm] at the place where the circle was last drawn


def draw_linked(
    layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup, name: str, link: str, **options: str
) -> None:
    """Draw a setting of the fingertip, and the button that links it to the size of the body."""
    row = layout.row(align=True)
    row.prop(settings, name, **options)
    row.prop(settings, link, text="", icon="LINKED")


def radius_zoom(_manager: bpy.types.PropertyGroup) -> tuple[float, float]:
    """Return the scale [px/mm] of Blender's radial control for the fingertip's radius, in x and y."""
    return _pixels[0], _pixels[0]


def amount_zoom(_manager: bpy.types.PropertyGroup) -> tuple[float, float]:
    """Return the scale of Blender's radial control for depth [px/mm] or force [px/N], in x and y."""
    each = PIXELS_PER_NEWTON if bpy.context.scene.dimple.by_force else _pixels[0]
    return each, each


def circle(context: bpy.types.Context, view: "View") -> list[shapes.Segment]:
    """Return the sides [px of the region] of the circle, none if the pointer is not on a body."""
    from ..operators.press import poke_input

    found = poke_input.touched(context, view)
    if found is None:
        return []
    point, normal, radius = found
    out = Vector(normal)
    across = out.orthogonal().normalized() * radius
    sides = shapes.circle(point, tuple(across), tuple(out.cross(across)))
    beside = Vector(point) + view.region_3d.view_rotation @ Vector((radius, 0.0, 0.0))
    ends = [_seen(view, place) for place in (point, beside)]
    if None not in ends:
        _pixels[0] = (ends[1] - ends[0]).length / context.scene.dimple.finger_radius_mm
    seen = [(_seen(view, a), _seen(view, b)) for a, b in sides]
    return [(tuple(a), tuple(b)) for a, b in seen if a is not None and b is not None]


def _seen(view: "View", place: shapes.Point) -> Vector | None:
    return location_3d_to_region_2d(view.region, view.region_3d, place)


class DIMPLE_WT_poke(bpy.types.WorkSpaceTool):
    """The tool that starts `dimple.poke` when the left mouse button is pressed."""

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
        if settings.press_by == "DEPTH":
            draw_linked(layout, settings, "press_depth_mm", "depth_follows")
        else:
            layout.prop(settings, "press_force_n")
        layout.operator(Op.KEY_PRESS, text="", icon="REC")

    @staticmethod
    def draw_cursor(context: bpy.types.Context, _tool: bpy.types.WorkSpaceTool, xy: tuple[int, int]) -> None:
        """Draw a circle of the fingertip's size on the body under the mouse, which is at xy [px of the window]."""
        from ..operators.press.poke_input import View

        region, window = context.region, context.window
        view = View(region, context.region_data, (xy[0] - region.x, xy[1] - region.y))
        sides = [[(x + region.x, y + region.y) for x, y in side] for side in circle(context, view)]
        screen = canvas.screen_of(context)._replace(width=window.width, height=window.height)
        canvas.draw_lines(sides, canvas.FINGERTIP, screen)


class DIMPLE_MT_object(bpy.types.Menu):
    """Dimple's operators for the selected meshes, as a menu so that the search (F3) finds them."""

    bl_label = "Dimple"

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        for verb in (
            Op.MAKE_SOFT, Op.POKE, Op.PLAY, Op.RESET, Op.ADD_FINGERTIP, Op.KEY_PRESS, Op.BAKE,
        ):  # fmt: skip
            layout.operator(verb)


def draw_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Draw Dimple's menu at the end of the Object menu."""
    menu.layout.separator()
    menu.layout.menu("DIMPLE_MT_object")


def register() -> None:
    bpy.utils.register_tool(DIMPLE_WT_poke, after={"builtin.transform"}, separator=True)
    bpy.utils.register_class(DIMPLE_MT_object)
    bpy.types.VIEW3D_MT_object.append(draw_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(draw_menu)
    bpy.utils.unregister_class(DIMPLE_MT_object)
    bpy.utils.unregister_tool(DIMPLE_WT_poke)
