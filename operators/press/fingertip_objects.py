"""Fingertips as objects of the scene: made, selected, and joined to the body that they press."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
from bpy_extras.object_utils import object_data_add
from mathutils import Matrix, Vector

from ..bridge import sizing
from . import modal_runs, sessions


def free(scene: bpy.types.Scene) -> list[int]:
    """Return the numbers of the fingertips that have no object yet."""
    return [number for number, tip in zip(sizing.NUMBERS, sizing.fingertips(scene), strict=True) if tip is None]


def body_of(obj: bpy.types.Object | None, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """Return the body of an object: for a fingertip the body that it was made for, for any other the object itself."""
    if obj is None or obj not in sessions.fingertip_objects(scene):
        return obj
    body = obj.dimple.presses
    return body if body and body.name in scene.objects else None


def leave_poke() -> None:
    """End a running poke, which would take the mouse and keys away from animating."""
    if any(run.kind == "poke" for run in modal_runs.runs):
        sessions.stop_all()


def make(
    context: bpy.types.Context,
    body: bpy.types.Object,
    number: int,
    centre: Sequence[float],
    radius: float,
    outward: Sequence[float],
) -> bpy.types.Object:
    """Add an empty as a fingertip of a body and select only it, so that the body is not moved and keyed with it.

    Args:
        centre, radius: [scene units].
        outward: direction away from the surface; it becomes the Z axis of the empty.
    """
    tip = object_data_add(context, None, name=f"Fingertip {number}")
    tip.empty_display_type, tip.empty_display_size = "SPHERE", radius
    turn = Vector((0.0, 0.0, 1.0)).rotation_difference(Vector(outward))
    tip.matrix_world = Matrix.LocRotScale(Vector(centre), turn, None)
    tip.dimple.presses, body.dimple.enabled = body, True
    setattr(context.scene.dimple, f"finger_{number}", tip)
    return tip


def select(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Select only this object, as a click does."""
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
