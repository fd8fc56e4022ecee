"""The chart of a dent's profile: a section at the deepest fingertip, with the surface at rest as a level line."""

from typing import Any

import bpy

from . import canvas, force_chart, shapes
from .canvas import FORCE, LINE_HEIGHT, MARGIN, Screen
from .readout import iface_
from .viewport_room import Room

SIZE = (230.0, 100.0)  # [px] at a resolution scale of 1
TOP = 0.2  # fraction of the height above the level line, for bulges
LEAST = 1e-3  # [m] smallest depth range of the chart


def deepest(entry: Any) -> int | None:
    """Return the index of the deepest fingertip in a body, None if none presses it."""
    depths = entry.frame.depths
    return int(depths.argmax()) if len(depths) and depths.max() > 0 else None


def draw(shown: list[tuple[bpy.types.Object, Any]], free: Room, screen: Screen) -> None:
    """Draw the profile of the first pressed body at the lower right of the free area."""
    from ..core import fields

    pressed = [(entry, tip) for _, entry in shown if (tip := deepest(entry)) is not None]
    scale = screen.scale
    wide, high = SIZE[0] * scale, SIZE[1] * scale
    left = free.right - wide
    if not pressed or left < free.left + (force_chart.SIZE[0] + MARGIN) * scale or free.top - free.bottom < 2 * high:
        return
    distance, depth = fields.profile(pressed[0][0].session, pressed[0][1])
    if not len(distance):
        return
    curve, ends = placed(distance.tolist(), depth.tolist(), (left, free.bottom), (wide, high))
    canvas.draw_filled((left, free.bottom), (left + wide, free.bottom + high + LINE_HEIGHT * scale), canvas.paper())
    level = free.bottom + (1 - TOP) * high
    canvas.draw_lines([((left, level), (left + wide, level))], canvas.faint(), screen)
    canvas.draw_lines(shapes.chained(curve), FORCE, screen)
    canvas.write(iface_("Profile"), (left + 4 * scale, free.bottom + high + 4 * scale), scale)
    canvas.write(f"{1e3 * ends[1]:g} mm", (left + 4 * scale, free.bottom + 5 * scale), scale)
    text = f"± {1e3 * ends[0]:.0f} mm"
    canvas.write(text, (left + wide - canvas.width(text, scale) - 4 * scale, free.bottom + 5 * scale), scale)


def placed(
    distance: list[float], depth: list[float], corner: shapes.Point, size: shapes.Point
) -> tuple[list[shapes.Point], tuple[float, float]]:
    """Return the curve on the screen [px], and the ranges of its box: half the width [m] and the depth [m]."""
    reach, low = max(map(abs, distance)), shapes.round_up(max(LEAST, *depth))
    (left, bottom), (wide, high) = corner, size
    curve = [
        (left + wide * (0.5 + 0.5 * at / reach), bottom + high * (1 - TOP) * max(1 - deep / low, 0.0))
        for at, deep in zip(distance, depth, strict=True)
    ]
    return [(x, min(y, bottom + high)) for x, y in curve], (reach, low)


