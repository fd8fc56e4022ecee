"""How a body is simulated: the planner's choice with its reason, the way out of it, and the comparison's chart."""

import json
import math
from collections.abc import Sequence
from typing import Any

import bpy

from ..operators.names import Op
from . import overlay, shapes
from .drawing import draw_notes
from .readout import iface_

LIVE = 0.6  # [s] a second: what Blender leaves to the simulation
SIZE = (330.0, 220.0)  # [px] of the chart, at a resolution scale of 1
ROOM = 0.06  # decades round the points
STAND_INS, OTHER = (0.55, 0.75, 1.0, 0.9), (0.95, 0.45, 0.35, 1.0)
LABELS = {"backward_euler": "backward Euler", "xpbd": "XPBD", "vertex_block_descent": "vertex block descent"}

_handlers: list[object] = []


class DIMPLE_PT_methods(bpy.types.Panel):
    """Show what moves in place of the mesh, and why."""

    bl_label = "Speed and Accuracy"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"
    bl_parent_id = "DIMPLE_PT_body"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Stand on meshes."""
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the choice, the tolerances, the reason and the comparison."""
        body, layout = context.object, self.layout
        layout.use_property_split = True
        layout.enabled = body.dimple.enabled
        settings = body.dimple
        layout.prop(settings, "moves")
        row = layout.row()
        row.active = settings.moves == "STAND_IN"
        row.prop(settings, "stand_in_vertices")
        column = layout.column(align=True)
        column.active = settings.moves == "AUTO"
        column.prop(settings, "tolerance_mm")
        column.prop(settings, "tolerance_percent")
        if settings.plan_reason:
            draw_notes(context, layout, [settings.plan_reason])
        layout.operator(Op.COMPARE_METHODS, icon="SORTSIZE")
        found = load(settings)
        if found:
            layout.prop(context.window_manager.dimple, "show_comparison")
            draw_table(layout, found)


def draw_table(layout: bpy.types.UILayout, found: Sequence[dict[str, Any]]) -> None:
    """List every way that was tried; those a session can take have a button."""
    for each in found:
        row = layout.row(align=True)
        for told in numbers(each):
            row.label(text=told, translate=False)
        if each["method"] == "semi_implicit":
            row.operator(Op.APPLY_METHOD, text="", icon="CHECKMARK").vertices = each["asked"]
        else:
            row.label(text="", icon="BLANK1")


def numbers(each: dict[str, Any]) -> tuple[str, ...]:
    """Return what a row of the table says: the way, s of computing for a second, error of the skin, of the force."""
    return (
        name_of(each),
        f"{each['cost']:.2g} s/s",
        f"{each['error']:.2g} mm",
        f"{each['force_error']:.0%}",
    )


def load(settings: Any) -> list[dict[str, Any]]:
    """Return the comparison that an object keeps; nothing where it has none."""
    return json.loads(settings.comparison) if settings.comparison else []


def name_of(each: dict[str, Any]) -> str:
    """Return what a way is called beside its numbers."""
    if each["method"] != "semi_implicit":
        return f"{LABELS.get(each['method'], each['method'])}, {each['vertices']}"
    return f"{each['vertices']}" if each["asked"] else f"{iface_('Mesh Itself')}, {each['vertices']}"


def draw_chart(found: Sequence[dict[str, Any]], settings: Any, corner: shapes.Point, scale: float, region: Any) -> None:
    """Draw error against cost, both in decades, from a corner [px]; the mesh itself has no error: it is a line."""
    points = [each for each in found if each["error"] > 0]
    if not points:
        return
    size = (SIZE[0] * scale, SIZE[1] * scale)
    ends = [
        _decades([LIVE, *(each["cost"] for each in found)]),
        _decades([settings.tolerance_mm, *(each["error"] for each in points)]),
    ]

    def place(cost: float, error: float) -> shapes.Point:
        return tuple(
            c + s * (math.log10(v) - low) / (high - low)
            for v, (low, high), c, s in zip((cost, error), ends, corner, size, strict=True)
        )

    right, top = corner[0] + size[0], corner[1] + size[1]
    margin = overlay.MARGIN * scale
    overlay._filled((corner[0] - margin, corner[1] - 2 * margin), (right + margin, top + 2 * margin), overlay.BACK)
    overlay._lines([((corner[0], top), tuple(corner)), (tuple(corner), (right, corner[1]))], overlay.FAINT, region)
    live, near = place(LIVE, 1.0)[0], place(1.0, settings.tolerance_mm)[1]
    mesh = place(next(each["cost"] for each in found if not each["error"]), 1.0)[0]
    for line, colour in (
        (((live, corner[1]), (live, top)), overlay.FAINT),
        (((corner[0], near), (right, near)), overlay.FAINT),
        (((mesh, corner[1]), (mesh, top)), overlay.FORCE),
    ):
        overlay._lines([line], colour, region)
    ours = sorted((each for each in points if each["method"] == "semi_implicit"), key=lambda each: each["cost"])
    overlay._lines(shapes.chained([place(each["cost"], each["error"]) for each in ours]), STAND_INS, region)
    for each in points:
        colour = STAND_INS if each in ours else OTHER
        at = place(each["cost"], each["error"])
        overlay._lines(shapes.circle(at, (4 * scale, 0.0), (0.0, 4 * scale)), colour, region)
        label = f"{each['vertices']}" if each in ours else LABELS.get(each["method"], each["method"])
        overlay._write(label, (at[0] + 6 * scale, at[1] + 4 * scale), scale)
    overlay._write(iface_("Mesh Itself"), (mesh + 4 * scale, corner[1] + 4 * scale), scale)
    overlay._write(iface_("Live"), (live - 36 * scale, top - 14 * scale), scale)
    overlay._write(f"{settings.tolerance_mm:g} mm", (corner[0] + 4 * scale, near + 4 * scale), scale)
    told = iface_("Error (mm) against cost (s of computing a second)")
    overlay._write(told, (corner[0], corner[1] - 24 * scale), scale)


def _decades(values: Sequence[float]) -> tuple[float, float]:
    logs = [math.log10(max(value, 1e-9)) for value in values]
    return min(logs) - ROOM, max(logs) + 4 * ROOM


def draw_over() -> None:
    """Draw the comparison of the active object over the viewport, where it is wanted (POST_PIXEL)."""
    context = bpy.context
    body = context.object
    if not context.window_manager.dimple.show_comparison or body is None or not body.dimple.comparison:
        return
    scale, region = context.preferences.system.ui_scale, context.region
    left, bottom = overlay._corner(context.area, scale)
    # at the top, clear of the numbers of a session
    top = region.height - (SIZE[1] + 110.0) * scale
    draw_chart(load(body.dimple), body.dimple, (left + overlay.MARGIN * scale, max(bottom, top)), scale, region)


_register_panel, _unregister_panel = bpy.utils.register_classes_factory([DIMPLE_PT_methods])


def register() -> None:
    """Register the panel, and let every 3D viewport draw the chart."""
    _register_panel()
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(draw_over, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Stop drawing, and unregister the panel."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    _unregister_panel()
