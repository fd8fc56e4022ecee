"""How a body is simulated: the planner's choice with its reason, the way out of it, and the comparison's chart."""

import math
from collections.abc import Sequence
from typing import Any

import bpy

from ..operators import calibration, compare
from ..operators.names import Op
from . import overlay, shapes
from .drawing import draw_notes
from .readout import iface_

SIZE = (330.0, 220.0)  # [px] of the chart, at a resolution scale of 1
ROOM = 0.06  # decades round the points
PROXIES = (0.55, 0.75, 1.0, 0.9)

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
        column.prop(context.scene.dimple, "frame_budget_percent")
        if settings.plan_reason:
            draw_notes(context, layout, [settings.plan_reason])
        layout.operator(Op.COMPARE_METHODS, icon="SORTSIZE")
        found = load(settings)
        if found:
            layout.prop(context.window_manager.dimple, "show_comparison")
            if calibration.load(settings.comparison).get("holds_for") != compare.holds_for(context.scene, body):
                draw_notes(context, layout, [iface_("The body or the fingertip was changed since: compare again")])
            draw_table(layout, found)


def draw_table(layout: bpy.types.UILayout, found: Sequence[dict[str, Any]]) -> None:
    """List every variant that was compared, each with a button that chooses it."""
    for each in found:
        row = layout.row(align=True)
        for number in numbers(each):
            row.label(text=number, translate=False)
        row.operator(Op.APPLY_METHOD, text="", icon="CHECKMARK").vertices = each["asked"]


def numbers(each: dict[str, Any]) -> tuple[str, ...]:
    """Return what a row of the table says: the way, s of computing for a second, error of the skin, of the force."""
    return (
        name_of(each),
        f"{each['cost']:.2g} s/s",
        f"{each['error']:.2g} mm",
        f"{each['force_error']:.0%}",
    )


def load(settings: Any) -> list[dict[str, Any]]:
    """Return the variants that were compared; none where they were not, or where what is kept is damaged."""
    variants = calibration.load(settings.comparison).get("variants")
    return variants if isinstance(variants, list) else []


def name_of(each: dict[str, Any]) -> str:
    """Return what a variant is called beside its numbers."""
    return f"{each['vertices']}" if each["asked"] else f"{iface_('Mesh Itself')}, {each['vertices']}"


def draw_chart(
    found: Sequence[dict[str, Any]], limits: shapes.Point, corner: shapes.Point, scale: float, region: Any
) -> None:
    """Draw error against cost, both in decades, from a corner [px]; the mesh itself has no error: it is a line.

    Args:
        limits: the cost that is live [s of a second], the error that is near enough [mm].
    """
    size = (SIZE[0] * scale, SIZE[1] * scale)
    (left, bottom), (right, top) = corner, (corner[0] + size[0], corner[1] + size[1])
    room = overlay.MARGIN * scale
    overlay.draw_filled((left - room, bottom - 2 * room), (right + 2 * room, top + room), overlay.BACK)
    overlay.draw_lines([((left, top), (left, bottom)), ((left, bottom), (right, bottom))], overlay.FAINT, region)
    (live, near), *spots = places(found, limits, corner, size)
    overlay.draw_lines([((live, bottom), (live, top)), ((left, near), (right, near))], overlay.FAINT, region)
    overlay.write(iface_("Live"), (live + 4 * scale, top - 30 * scale), scale)
    overlay.write(f"{limits[1]:g} mm", (left + 4 * scale, near + 4 * scale), scale)
    variants = list(zip(found, spots, strict=True))
    proxies = sorted(at for each, at in variants if each["error"] > 0)
    overlay.draw_lines(shapes.chained(proxies), PROXIES, region)
    named: list[tuple[float, float, float]] = []  # where names begin, and how wide they are
    for each, (x, y) in variants:
        if not each["error"]:
            overlay.draw_lines([((x, bottom), (x, top))], overlay.FORCE, region)
            overlay.write(iface_("Mesh Itself"), (x + 4 * scale, top - 14 * scale), scale)
            continue
        label = f"{each['vertices']}"
        overlay.draw_lines(shapes.circle((x, y), (4 * scale, 0.0), (0.0, 4 * scale)), PROXIES, region)
        wide = overlay.width(label, scale)
        name = (min(x + 6 * scale, right + 2 * room - wide), y + 4 * scale, wide)
        if all(apart(name, other, scale) for other in named):  # the table has the names of all
            overlay.write(label, name[:2], scale)
            named.append(name)
    told = iface_("Error (mm) against cost (s of computing a second)")
    overlay.write(told, (left, bottom - 20 * scale), scale)


def apart(one: tuple[float, float, float], other: tuple[float, float, float], scale: float) -> bool:
    """Tell whether two names (x, y, width) [px] can both be read."""
    beside = one[0] >= other[0] + other[2] or other[0] >= one[0] + one[2]
    return beside or abs(one[1] - other[1]) >= overlay.TEXT_SIZE * scale


def places(
    found: Sequence[dict[str, Any]], limits: shapes.Point, corner: shapes.Point, size: shapes.Point
) -> list[shapes.Point]:
    """Return where the limits and then each way lie in a box on the screen: cost to the right, error up, in decades."""
    spots = [limits, *((each["cost"], each["error"]) for each in found)]
    costs, errors = decades([cost for cost, _ in spots]), decades([error for _, error in spots if error > 0])
    return [
        tuple(
            start + extent * (math.log10(max(value, 1e-9)) - low) / (high - low)
            for value, (low, high), start, extent in zip(spot, (costs, errors), corner, size, strict=True)
        )
        for spot in spots
    ]


def decades(values: Sequence[float]) -> tuple[float, float]:
    """Return the ends of an axis for values, as powers of ten, with room for labels."""
    logs = [math.log10(max(value, 1e-9)) for value in values]
    return min(logs) - ROOM, max(logs) + 4 * ROOM


def draw_over() -> None:
    """Draw the comparison of the active object over the viewport, where it is wanted (POST_PIXEL)."""
    context = bpy.context
    body = context.object
    if not context.window_manager.dimple.show_comparison or body is None or not body.dimple.comparison:
        return
    from ..operators import planning  # not at import: it needs numpy, and enabling must be quick

    scale, region = context.preferences.system.ui_scale, context.region
    limits = (planning.budget_of(context.scene, body), body.dimple.tolerance_mm)
    draw_chart(load(body.dimple), limits, chart_corner(context.area, region, scale), scale, region)


def chart_corner(area: bpy.types.Area, region: bpy.types.Region, scale: float) -> shapes.Point:
    """Return where [px] the chart begins: at the top, clear of the numbers of a session."""
    left, bottom = overlay.free_corner(area, scale)
    return left + overlay.MARGIN * scale, max(bottom, region.height - (SIZE[1] + 110.0) * scale)


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
