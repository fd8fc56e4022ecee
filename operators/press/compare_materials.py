"""Twins: two objects of one shape and two materials, to compare them: one press presses both."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import bpy
from mathutils import Matrix, Vector

from ...core.messages import Message
from ..messages import report, say
from ..names import Op
from . import modal_runs, polls, sessions

if TYPE_CHECKING:
    from ...core.session import Finger
    from .sessions import LiveBody

APART = 1.25  # of the width: between the middles of twins
Fingers = Sequence["Finger | None"]


def other(obj: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """Return the twin of an object in a scene: its original, or its copy."""
    found = obj.dimple.twin
    if found is None:
        found = next((each for each in scene.objects if each.dimple.twin == obj), None)
    return found if found and found.name in scene.objects and found != obj else None


def joined(bodies: Iterable[bpy.types.Object], scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """Return objects together with their twins, each once."""
    found = list(bodies)
    for obj in list(found):
        twin = other(obj, scene) if obj.type == "MESH" else None
        if twin and twin not in found:
            found.append(twin)
    return found


def shared(pressed: Mapping[int, Fingers], scene: bpy.types.Scene) -> dict[int, Fingers]:
    """Return the fingertips on each body, with those on one twin pressing the other at the same place too."""
    result = dict(pressed)
    for uid, fingers in pressed.items():
        pair = _pair(uid, scene) if any(fingers) else None
        if pair and not any(pressed.get(pair[1].link.uid, ())):
            result[pair[1].link.uid] = moved(fingers, *pair)
    return result


def source(body: LiveBody) -> LiveBody | None:
    """Return the body that a twin is a copy of, where it runs."""
    obj = bpy.data.objects.get(body.name)
    return sessions.get(obj.dimple.twin) if obj and obj.dimple.twin else None


def moved(fingers: Fingers, here: LiveBody, there: LiveBody) -> list[Finger | None]:
    """Return fingertips that press a body as others do its twin."""
    way = Matrix(there.matrix.tolist()) @ Matrix(here.matrix.tolist()).inverted()

    def at(place: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple(there.link.scale * (way @ (Vector(place) / here.link.scale)))

    def placed(finger: Finger) -> Finger:
        inward = (way.to_3x3() @ Vector(finger.inward)).normalized()
        via = tuple(map(at, finger.via))
        return finger._replace(position=at(finger.position), inward=tuple(inward), via=via)

    return [finger and placed(finger) for finger in fingers]


def _pair(uid: int, scene: bpy.types.Scene) -> tuple[LiveBody, LiveBody] | None:
    body = sessions.sessions.get(uid)
    obj = bpy.data.objects.get(body.name) if body else None
    twin = sessions.get(other(obj, scene)) if obj else None
    return (body, twin) if body and twin else None


class DIMPLE_OT_compare_materials(polls.Declared, bpy.types.Operator):
    """Compare two materials: put a copy of the object, with a material of its own, beside it. One press presses both"""

    bl_idname = Op.COMPARE_MATERIALS
    bl_label = "Compare Materials"
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode, polls.needs_mesh, polls.is_own,
        polls.need(
            lambda context: context.object.dimple.enabled and context.object.active_material,
            "Make the object soft first",
        ),
        polls.need(
            lambda context: not other(context.object, context.scene),
            "The object has a twin already: use one of the two materials first",
        ),
        polls.need(
            lambda _: not (sessions.sessions or modal_runs.runs),
            "Something is being pressed: end that first, with Esc or Reset",
        ),
    )  # fmt: skip

    def run(self, context: bpy.types.Context) -> None:
        obj = context.object
        twin = obj.copy()
        twin.data, twin.name = obj.data.copy(), f"{obj.name} B"
        twin.animation_data_clear()
        twin.constraints.clear()
        twin.parent = None
        copies = {slot.material: slot.material.copy() for slot in obj.material_slots if slot.material}
        for slot in twin.material_slots:
            if slot.material:
                copy = copies[slot.material]
                copy.name, slot.material = f"{slot.material.name} B", copy
        for collection in obj.users_collection:
            collection.objects.link(twin)
        twin.matrix_world = Matrix.Translation(_to_the_right(context, obj)) @ obj.matrix_world
        twin.dimple.twin = obj
        twin.select_set(False)
        said = Message('"{name}" is its twin: select it and change its material', name=twin.name)
        say(self, {"INFO"}, said)


class DIMPLE_OT_use_material(polls.Declared, bpy.types.Operator):
    """Decide between two compared materials: keep that of the selected object, and remove the copy"""

    bl_idname = Op.USE_MATERIAL
    bl_label = "Use This Material"
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode,
        polls.need(
            lambda context: context.object and other(context.object, context.scene),
            "The object has no twin: Compare Materials makes one",
        ),
        polls.is_free,
    )

    def run(self, context: bpy.types.Context) -> None:
        """Give the original the materials that were chosen, and remove its copy."""
        chosen, left_out = context.object, other(context.object, context.scene)
        original, copy = (left_out, chosen) if chosen.dimple.twin == left_out else (chosen, left_out)
        report(self, sessions.stop_all())
        left = {slot.material for slot in left_out.material_slots} - {slot.material for slot in chosen.material_slots}
        if chosen == copy:
            for theirs, ours in zip(copy.material_slots, original.material_slots, strict=False):
                ours.material = theirs.material
        mesh = copy.data
        bpy.data.objects.remove(copy)
        for data, users in ((bpy.data.meshes, [mesh]), (bpy.data.materials, left - {None})):
            for each in users:
                if not each.users:
                    data.remove(each)
        context.view_layer.objects.active = original
        original.select_set(True)


def _to_the_right(context: bpy.types.Context, obj: bpy.types.Object) -> Vector:
    """Return the way from an object to its twin in the scene: to the right as it is seen, level."""
    view = context.region_data if context.area and context.area.type == "VIEW_3D" else None
    right = Vector((1.0, 0.0, 0.0))
    if view:
        right = view.view_rotation @ right
        right.z = 0.0
        right = right.normalized() if right.length > 1e-3 else Vector((1.0, 0.0, 0.0))
    corners = [(obj.matrix_world @ Vector(corner)) @ right for corner in obj.bound_box]
    return right * max(APART * (max(corners) - min(corners)), 1e-6)
