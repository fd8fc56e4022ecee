"""The chart of a comparison of proxies over the viewport: error against cost."""

import math
from collections.abc import Sequence
from typing import Any

import bpy

from ..operators import calibration
from . import canvas, shapes
from .canvas import FORCE, MARGIN, Screen
from .readout import iface_
from .room import Room, free_room

SIZE = (330.0, 220.0)  # [px] of the chart, at a resolution scale of 1
ROOM = 0.06  # decades round the points
PROXIES = (0.55, 0.75, 1.0, 0.9)

_handlers: list[object] = []


def load(settings: Any) -> list[dict[str, Any]]:
    """Return the variants of an object that were compared; none where there are none or the text is damaged."""
    variants = calibration.load(settings.comparison).get("variants")
    return variants if isinstance(variants, list) else []


def name_of(variant: dict[str, Any]) -> str:
    """Return the name of a variant: its vertices."""
    return f"{variant['vertices']}" if variant["asked"] else f"{iface_('Full Mesh')}, {variant['vertices']}"


def draw_chart(variants: Sequence[dict[str, Any]], limits: shapes.Point, corner: shapes.Point, screen: Screen) -> None:
    """Draw error against cost, both logarithmic. The full mesh has no error, so it is a vertical line.

    Args:
        limits: the cost that runs live [s per second], and the tolerance of the surface [mm].
        corner: lower left [px].
    """
    scale = screen.scale
    size = (SIZE[0] * scale, SIZE[1] * scale)
    (left, bottom), (right, top) = corner, (corner[0] + size[0], corner[1] + size[1])
    room = MARGIN * scale
    canvas.draw_filled((left - room, bottom - 2 * room), (right + 2 * room, top + room), canvas.paper())
    canvas.draw_lines([((left, top), (left, bottom)), ((left, bottom), (right, bottom))], canvas.faint(), screen)
    (live, near), *spots = places(variants, limits, corner, size)
    canvas.draw_lines([((live, bottom), (live, top)), ((left, near), (right, near))], canvas.faint(), screen)
    canvas.write(iface_("Live"), (live + 4 * scale, top - 30 * scale), scale)
    canvas.write(f"{limits[1]:g} mm", (left + 4 * scale, near + 4 * scale), scale)
    placed = list(zip(variants, spots, strict=True))
    proxies = sorted(at for variant, at in placed if variant["error"] > 0)
    canvas.draw_lines(shapes.chained(proxies), PROXIES, screen)
    named: list[tuple[float, float, float]] = []  # where names begin, and how wide they are
    for variant, (x, y) in placed:
        if not variant["error"]:
            canvas.draw_lines([((x, bottom), (x, top))], FORCE, screen)
            canvas.write(iface_("Full Mesh"), (x + 4 * scale, top - 14 * scale), scale)
            continue
        label = f"{variant['vertices']}"
        canvas.draw_lines(shapes.circle((x, y), (4 * scale, 0.0), (0.0, 4 * scale)), PROXIES, screen)
        wide = canvas.width(label, scale)
        name = (min(x + 6 * scale, right + 2 * room - wide), y + 4 * scale, wide)
        if all(apart(name, other, scale) for other in named):  # the table has the names of all
            canvas.write(label, name[:2], scale)
            named.append(name)
    canvas.write(iface_("Error (mm) against cost (s per second)"), (left, bottom - 20 * scale), scale)


def apart(one: tuple[float, float, float], other: tuple[float, float, float], scale: float) -> bool:
    """Return whether two names (x, y, width) [px] can both be read."""
    beside = one[0] >= other[0] + other[2] or other[0] >= one[0] + one[2]
    return beside or abs(one[1] - other[1]) >= canvas.TEXT_SIZE * scale


def places(
    variants: Sequence[dict[str, Any]], limits: shapes.Point, corner: shapes.Point, size: shapes.Point
) -> list[shapes.Point]:
    """Return where the limits and then each variant lie on the screen [px]: cost to the right, error up, in decades."""
    spots = [limits, *((variant["cost"], variant["error"]) for variant in variants)]
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
    """Draw the comparison of the active object over the viewport, where it is switched on (POST_PIXEL)."""
    context = bpy.context
    body = context.object
    if not context.window_manager.dimple.show_comparison or body is None or not body.dimple.comparison:
        return
    if not canvas.overlays_shown(context):
        return
    from ..operators import planning  # not at import: it needs numpy, and enabling must be quick

    screen = canvas.screen_of(context)
    limits = (planning.budget_of(context.scene, body), body.dimple.tolerance_mm)
    free = free_room(context, screen.scale)
    if free:
        draw_chart(load(body.dimple), limits, chart_corner(free, screen.scale), screen)


def chart_corner(free: Room, scale: float) -> shapes.Point:
    """Return the lower left corner [px] of the chart: at the top of what is free, clear of the numbers of a session."""
    return free.left + MARGIN * scale, max(free.bottom, free.top - (SIZE[1] + 40.0) * scale)


def register() -> None:
    """Add the chart to every 3D viewport."""
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(draw_over, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Stop drawing."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
