"""What of a viewport is free for numbers: beside its toolbar, sidebar and headers, and in one of its four views."""

from typing import NamedTuple

import bpy

from .canvas import LINE_HEIGHT, MARGIN

BLENDERS_LINES = 3  # of text in the upper left corner: the view, the object, the unit
TAB_OF = "DIMPLE_PT_session"  # the panel of the sidebar that shows the numbers too
_readouts: set[int] = set()  # areas in whose sidebar the numbers are unfolded


class Room(NamedTuple):
    """A rectangle of a region [px]."""

    left: float
    bottom: float
    right: float
    top: float


def free_room(context: bpy.types.Context, scale: float) -> Room | None:
    """Return the free area of the region that is being drawn, None where another of the four views has the numbers.

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
        x, y = other.x - region.x, other.y - region.y  # it may lie over the region
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


def note_readout(area: bpy.types.Area, *, shown: bool) -> None:
    """Note whether the sidebar of an area shows the numbers: Blender does not tell which panels are collapsed."""
    (_readouts.add if shown else _readouts.discard)(area.as_pointer())


def shown_in_sidebar(context: bpy.types.Context, body: bpy.types.Object) -> bool:
    """Tell whether the sidebar shows the numbers of a body already."""
    if body != context.object or not context.space_data.show_region_ui or context.area.as_pointer() not in _readouts:
        return False
    sidebar = next((region for region in context.area.regions if region.type == "UI" and region.width > 1), None)
    panel = getattr(bpy.types, TAB_OF, None)
    return bool(sidebar and panel and sidebar.active_panel_category == panel.bl_category)
