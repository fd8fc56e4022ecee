"""The circle under the mouse: as large as the fingertip, on the body that a click would press."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from . import canvas, shapes

if TYPE_CHECKING:
    from ..operators.press.pointer import View

PIXELS_PER_NEWTON = 20.0  # while a force is changed: one of 5 N is drawn as a circle that is easily dragged
_pixels = [5.0]  # in a millimetre, where the circle was drawn last


def radius_zoom(_manager: bpy.types.PropertyGroup) -> tuple[float, float]:
    """Return how many pixels a millimetre has, for Blender's control that sizes the circle round the mouse."""
    return _pixels[0], _pixels[0]


def amount_zoom(_manager: bpy.types.PropertyGroup) -> tuple[float, float]:
    """Return how many pixels a millimetre of depth has, or a newton."""
    each = PIXELS_PER_NEWTON if bpy.context.scene.dimple.by_force else _pixels[0]
    return each, each


def draw(context: bpy.types.Context, xy: tuple[int, int]) -> None:
    """Draw the circle, where the mouse at xy [px of the window] is on a body."""
    from ..operators.press.pointer import View

    region, window = context.region, context.window
    view = View(region, context.region_data, (xy[0] - region.x, xy[1] - region.y))
    sides = [[(x + region.x, y + region.y) for x, y in side] for side in circle(context, view)]
    screen = canvas.screen_of(context)._replace(width=window.width, height=window.height)
    canvas.draw_lines(sides, canvas.FINGERTIP, screen)


def circle(context: bpy.types.Context, view: View) -> list[shapes.Segment]:
    """Return the sides [px of the region] of the circle, none where there is no body."""
    from ..operators.press import pointer

    found = pointer.touched(context, view)
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


def _seen(view: View, place: shapes.Point) -> Vector | None:
    return location_3d_to_region_2d(view.region, view.region_3d, place)
