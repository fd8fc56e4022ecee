"""Convert input of mouse, tablet and keyboard to events of the poke, and find the surface under the pointer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import bpy
import numpy as np
from bpy_extras import view3d_utils

from ...core.mesh.ray import ray_hit
from ...core.poke import Hit, Kind, PokeEvent
from ...core.vectors import Vector, along, dot, length
from ..bridge import sizing
from ..names import DEAD_MAN, POKE_TOOL
from .sessions import LiveBody, fingertip_objects, sessions

KEYS = {"SPACE": Kind.PAUSE, "RET": Kind.KEEP, "NUMPAD_ENTER": Kind.KEEP}
FINGERS = {"ONE": 1, "TWO": 2, "THREE": 3}
NAVIGATION = {
    "MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSESMARTZOOM",
    "HOME", "ACCENT_GRAVE",
}  # fmt: skip
PASSING = {DEAD_MAN, *NAVIGATION}
SIZING = "F"  # handled by Blender through the tool's keymap; not during a stroke, whose release it would swallow
SIDES = {"N", "T"}  # keys that open and close the sidebar and the toolbar
SAVE = "S"
DOWN = {"PRESS", "DOUBLE_CLICK"}

Shapes = Mapping[int, np.ndarray]


class Under(NamedTuple):
    """The mesh under the pointer, with the point and the normal there in scene coordinates."""

    obj: bpy.types.Object
    point: Vector
    normal: Vector


@dataclass(frozen=True, slots=True)
class View:
    """The viewport under the pointer, and the position of the pointer in it [px]."""

    region: bpy.types.Region
    region_3d: bpy.types.RegionView3D
    at: tuple[int, int]


def view_under(context: bpy.types.Context, event: bpy.types.Event) -> View | None:
    """Return the viewport under the pointer, or None if it is over anything else."""
    x, y = event.mouse_x, event.mouse_y
    for area in context.window.screen.areas:
        if area.type != "VIEW_3D" or not _inside(area, x, y):
            continue
        over = [region for region in area.regions if region.width > 1 and region.height > 1 and _inside(region, x, y)]
        # sidebar and toolbar may lie over the viewport
        if over and all(region.type == "WINDOW" for region in over):
            return View(over[0], over[0].data, (x - over[0].x, y - over[0].y))
    return None


def poke_event(
    event: bpy.types.Event, view: View | None, bodies: Mapping[int, LiveBody], shapes: Shapes, *, pressing: bool
) -> PokeEvent | None:
    """Return the poke's event for an event of Blender, or None if the poke does not use it.

    Args:
        view: the viewport under the pointer.
        shapes: positions (N, 3) of bodies when the stroke began, by session_uid; for others the current ones are used.
        pressing: a stroke is under way.
    """
    kind, down = event.type, event.value in DOWN
    if kind == "ESC" and down:
        return PokeEvent(kind=Kind.LEAVE)
    if kind == "LEFTMOUSE" and event.value == "RELEASE":
        return PokeEvent(kind=Kind.RELEASE) if pressing else None
    if view is None:
        return None
    if kind == "MOUSEMOVE" and pressing:
        return _pointed(Kind.MOVE, event, view, bodies, shapes)
    if not down:
        return None
    if kind == "LEFTMOUSE" and not event.alt:
        return _pointed(Kind.PRESS, event, view, bodies, {})
    if kind == "RIGHTMOUSE":
        return PokeEvent(kind=Kind.LEAVE)
    if event.ctrl or event.shift or event.alt or event.oskey:
        return None
    if kind in FINGERS:
        return PokeEvent(kind=Kind.FINGER, amount=FINGERS[kind])
    return PokeEvent(kind=KEYS[kind]) if kind in KEYS else None


def passes(event: bpy.types.Event, view: View | None, *, pressing: bool, undo: bool = False) -> bool:
    """Return whether an event that the poke does not use is passed on to Blender: navigation, clicks beside the bodies,
    the keys that size the fingertip, those of sidebar and toolbar, the haptic device's dead-man key, saving, undo, and
    all events outside the viewport.

    Args:
        pressing: a stroke is under way.
        undo: a step since the start of the poke can be undone; earlier steps must not be.
    """
    if event.type == "Z" and (event.ctrl or event.oskey):
        return undo and not pressing
    if view is None or event.type in PASSING or event.type.startswith(("NDOF", "NUMPAD", "TIMER", "WINDOW")):
        return True
    if event.type == SAVE and (event.ctrl or event.oskey) and not event.alt:
        return True  # saving is safe: the handlers put the bodies at rest first
    if event.type in SIDES:
        return not (event.ctrl or event.shift or event.alt or event.oskey)
    if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "LEFTMOUSE", SIZING}:
        return event.alt or not pressing
    return event.type == "NONE"


def choose_tool(context: bpy.types.Context) -> None:
    """Make Poke the active tool if the context is a viewport."""
    if context.area and context.area.type == "VIEW_3D" and context.window:
        bpy.ops.wm.tool_set_by_id(name=POKE_TOOL)


def under(context: bpy.types.Context, view: View) -> Under | None:
    """Return the mesh under the pointer if a click with the tool would press it: it is selected, or a soft body."""
    origin, direction = _ray(view)
    graph = context.evaluated_depsgraph_get()
    _, at, normal, _, found, _ = context.scene.ray_cast(graph, origin, direction)
    obj = found.original if found else None
    if obj is None or obj.type != "MESH" or not (obj.dimple.enabled or obj.select_get()):
        return None
    return Under(obj, tuple(at), tuple(normal))


def touched(context: bpy.types.Context, view: View) -> tuple[Vector, Vector, float] | None:
    """Return point and normal of a body under the pointer, and the fingertip's radius; None while the mouse presses."""
    radius = context.scene.dimple.finger_radius_mm / 1e3
    if any(context.scene.dimple.active_finger - 1 in body.poked for body in sessions.values()):
        return None
    if not sessions:
        found = under(context, view)
        return found and (found.point, found.normal, radius / sizing.metres_per_unit(context.scene, found.obj))
    hit = nearest(*_ray(view), sessions, {})
    if hit is None:
        return None
    body = sessions[hit.body]
    return body.to_world(hit.point), hit.normal, radius / body.link.scale


def fingertip_under(context: bpy.types.Context, view: View) -> bpy.types.Object | None:
    """Return the fingertip object whose sphere is under the pointer and in front of any surface."""
    origin, direction = _ray(view)
    hit, place, *_ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
    first, found = length(along(tuple(place), origin, -1.0)) if hit else np.inf, None
    for tip in fingertip_objects(context.scene):
        if tip and tip.type == "EMPTY" and tip.visible_get():
            centre = along(tuple(tip.matrix_world.translation), origin, -1.0)
            radius, ahead = tip.empty_display_size * tip.matrix_world.median_scale, dot(centre, direction)
            square = radius**2 - dot(centre, centre) + ahead**2
            if square > 0 and 0 < (away := ahead - square**0.5) < first:
                first, found = away, tip
    return found


def nearest(origin: Vector, direction: Vector, bodies: Mapping[int, LiveBody], shapes: Shapes) -> Hit | None:
    """Return the first hit of a ray of the scene, in the session space of the body that it hits."""
    best, found = np.inf, None
    for uid, body in bodies.items():
        scale = body.link.scale
        x, y, z = (scale * c for c in origin)
        positions = shapes[uid] if uid in shapes else body.session.positions()
        hit = ray_hit((x, y, z), direction, positions, body.triangles)
        if hit and hit[0] / scale < best:
            best, found = hit[0] / scale, Hit(point=hit[1], normal=hit[2], body=uid)
    return found


def _pointed(
    kind: Kind, event: bpy.types.Event, view: View, bodies: Mapping[int, LiveBody], shapes: Shapes
) -> PokeEvent:
    origin, direction = _ray(view)
    hit = nearest(origin, direction, bodies, shapes)
    return PokeEvent(kind=kind, hit=hit, view=direction, pressure=event.pressure if event.is_tablet else 1.0)


def _ray(view: View) -> tuple[Vector, Vector]:
    """Return the origin of the pointer's ray in the scene, and its unit direction."""
    origin = tuple(view3d_utils.region_2d_to_origin_3d(view.region, view.region_3d, view.at))
    return origin, tuple(view3d_utils.region_2d_to_vector_3d(view.region, view.region_3d, view.at).normalized())


def _inside(box: bpy.types.Area | bpy.types.Region, x: int, y: int) -> bool:
    return box.x <= x < box.x + box.width and box.y <= y < box.y + box.height
