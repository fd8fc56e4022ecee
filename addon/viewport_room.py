"""The area of a viewport for numbers: clear of toolbar, sidebar and headers, and in only one view of a quad view."""

from typing import NamedTuple

import bpy

from .canvas import LINE_HEIGHT, MARGIN

BLENDERS_LINES = 3  # lines of Blender's own text in the upper left corner: the view, the object, the unit


class Room(NamedTuple):
    """A rectangle of a region [px]."""

    left: float
    bottom: float
    right: float
    top: float


def free_room(context: bpy.types.Context, scale: float) -> Room | None:
    """Return the free area of the region that is being drawn, None if another view of a quad view has the numbers.

    Args:
        scale: the resolution scale of the interface.
    """
    area, region = context.area, context.region
    if context.space_data.region_quadviews:
        views = [each for each in area.regions if each.type == "WINDOW" and each.width > 1]
        if region != max(views, key=lambda each: (each.x, each.y)):
            return None
    left, bottom, right, top = 0.0, 0.0, float(region.width), float(region.height)
    for other in area.regions:
        x, y = other.x - region.x, other.y - region.y  # with region overlap, `other` lies over the region
        over = x < region.width and y < region.height and x + other.width > 0 and y + other.height > 0
        if other.type == "WINDOW" or min(other.width, other.height) <= 1 or not over:
            continue
        if other.type in ("TOOLS", "UI"):
            if x + other.width / 2 < region.width / 2:
                left = max(left, x + other.width)
            else:
                right = min(right, x)
        elif y + other.height / 2 < region.height / 2:
            bottom = max(bottom, y + other.height)
        else:
            top = min(top, y)
    if context.space_data.overlay.show_text:
        top -= BLENDERS_LINES * LINE_HEIGHT * scale
    margin = MARGIN * scale
    return Room(left + margin, bottom + 2 * margin, right - margin, top - margin)
