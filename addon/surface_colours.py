"""Colours on the surface of running bodies, with their scale.

They are drawn over the viewport and change neither mesh nor material.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

from ..operators.experiment.blind_trial import is_blind
from . import canvas, colour_map, overlay, shapes, viewport_room
from .canvas import LINE_HEIGHT, Screen
from .readout import iface_
from .viewport_room import Room

if TYPE_CHECKING:
    import numpy as np

LEGEND = (14.0, 150.0)  # [px] width and height of the colour bar, at a resolution scale of 1
LEAST = 0.3  # fraction of the scale: if no value reaches it, the scale shrinks
NOTHING = 0.1  # [kPa, mm or %] smallest end of a scale
SIGNED = {"stretch"}
LIFT = 2e-4  # shift towards the viewer in normalized depth, so that the mesh does not hide the colours on it
SHADE = 0.3  # fraction by which colours darken where the surface is seen edge-on


class Coloured(NamedTuple):
    """The coloured surface of a body: frame, field, positions (n, 3) in the scene, normals, triangles and values."""

    frame: Any
    name: str
    positions: "np.ndarray"
    normals: "np.ndarray"
    triangles: "np.ndarray"
    values: "np.ndarray"


_made: dict[int, Coloured] = {}
_scales: dict[str, float] = {}  # upper end of the scale of each quantity


def draw_surfaces() -> None:
    """Draw colours in the scene (POST_VIEW)."""
    if is_blind():
        return
    context = bpy.context
    settings, shown = context.scene.dimple, overlay.shown_bodies(context)
    if not shown:
        _made.clear()
        return
    if settings.show_field != "NONE":
        bodies = [made(body.session_uid, entry, settings.show_field.lower()) for body, entry in shown]
        ends = scale_of(settings.show_field.lower(), bodies)
        for each in bodies:
            draw_coloured(each, ends, context.region_data)


def draw_scales() -> None:
    """Draw the scale of the colours on top of the picture (POST_PIXEL)."""
    if is_blind():
        return
    context = bpy.context
    name = context.scene.dimple.show_field.lower()
    if name not in _scales or not overlay.shown_bodies(context):
        return
    screen = canvas.screen_of(context)
    if free := viewport_room.free_room(context, screen.scale):
        draw_scale(name, (bottom_of(name), _scales[name]), free, screen)


def made(uid: int, entry: Any, name: str) -> Coloured:
    """Return the coloured surface of a body now; it is computed once per frame."""
    import numpy as np

    from ..core import fields
    from ..core.reduction.cells import vertex_normals

    session = entry.session
    last = _made.get(uid)
    if last and last.frame is entry.frame and last.name == name:
        return last
    skin, triangles = session.skin(), session.model.mesh.triangles
    # contiguous, because Blender ignores the strides of an array
    _made[uid] = Coloured(
        entry.frame, name, np.ascontiguousarray(skin / entry.link.scale, np.float32),
        vertex_normals(triangles, skin).astype(np.float32), np.ascontiguousarray(triangles, np.int32),
        fields.field(session, name),
    )  # fmt: skip
    return _made[uid]


def bottom_of(name: str) -> float:
    """Return the lower end of the scale of a quantity."""
    return -_scales[name] if name in SIGNED else 0.0


def scale_of(name: str, bodies: list[Coloured]) -> tuple[float, float]:
    """Return the ends of the scale that all bodies share; they stay constant as long as the values fit."""
    highest = max([NOTHING, *(float(abs(each.values).max(initial=0.0)) for each in bodies)])
    before = _scales.get(name, 0.0)
    if not LEAST * before <= highest <= before:
        _scales[name] = shapes.round_up(highest)
    return bottom_of(name), _scales[name]


def draw_coloured(each: Coloured, ends: tuple[float, float], view: bpy.types.RegionView3D) -> None:
    """Draw a surface in the colours of its values."""
    import gpu
    import numpy as np

    colours = np.ones((len(each.values), 4), np.float32)
    colours[:, :3] = colour_map.coloured(each.values, ends, each.name in SIGNED)
    toward = np.array(view.view_matrix, np.float32)[2, :3]
    colours[:, :3] *= (1 - SHADE + SHADE * np.abs(each.normals @ toward))[:, None]
    with gpu.matrix.push_pop_projection():
        lifted = gpu.matrix.get_projection_matrix().copy()
        lifted[2] -= LIFT * lifted[3]
        gpu.matrix.load_projection_matrix(lifted)
        canvas.draw("TRIS", each.positions, colours=colours, indices=each.triangles, behind=False)


def draw_scale(name: str, ends: tuple[float, float], free: Room, screen: Screen) -> None:
    """Draw the scale at the right of the free area."""
    from ..core.fields import UNITS

    scale = screen.scale
    items = bpy.context.scene.dimple.bl_rna.properties["show_field"].enum_items
    title = f"{iface_(items[name.upper()].name)} ({UNITS[name]})"
    wide = max(canvas.width(title, scale), (LEGEND[0] + 50.0) * scale)
    high = min(LEGEND[1] * scale, free.top - free.bottom - 3 * LINE_HEIGHT * scale)
    left, bottom = free.right - wide, free.bottom
    if high < LINE_HEIGHT * scale or left < free.left:
        return
    edge = 4 * scale
    top = bottom + high + 2 * LINE_HEIGHT * scale
    canvas.draw_filled((left - edge, bottom - edge), (free.right + edge, top))
    draw_bar((left, bottom + 5 * scale), (LEGEND[0] * scale, high), name in SIGNED)
    canvas.write(title, (left, bottom + high + LINE_HEIGHT * scale), scale)
    for share in (0.0, 0.5, 1.0):
        value = ends[0] + share * (ends[1] - ends[0])
        canvas.write(f"{value:g}", (left + (LEGEND[0] + 6.0) * scale, bottom + share * high), scale)


def draw_bar(corner: tuple[float, float], size: tuple[float, float], signed: bool) -> None:
    """Draw the colour bar of a scale, with the lowest value at the bottom."""
    import numpy as np

    (left, bottom), (wide, high) = corner, size
    colours = np.repeat(colour_map.table(signed), 2, axis=0)
    points = np.zeros((len(colours), 3), np.float32)
    points[0::2, 0], points[1::2, 0] = left, left + wide
    points[:, 1] = bottom + high * np.repeat(np.linspace(0, 1, len(colours) // 2), 2)
    paint = np.concatenate([colours, np.ones((len(colours), 1))], axis=1).astype(np.float32)
    canvas.draw("TRI_STRIP", points, colours=paint)


register, unregister = canvas.drawing(draw_surfaces, draw_scales)
