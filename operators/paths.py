"""Where keyframes lead fingertips and colliders, read from their curves: what they will press is then known."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.reduction.grading import Led, pressed_by
from . import contact, timeline
from .shape_keys import curve_bags

if TYPE_CHECKING:
    from ..core.base import Floats
    from ..core.body.model import Model
    from ..core.reduction.grading import Pressed
    from .object_link import ObjectLink

STILL = {"BEVEL", "DECIMATE", "MIRROR", "REMESH", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WELD"}  # modifiers


def pressed_along(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model, link: ObjectLink) -> Pressed | None:
    """Return where fingertip objects and colliders will press an object, None where that is not known.

    It is where they have keyframes, or stand, and nothing else moves them or the object.
    """
    tips = [tip for tip in (scene.dimple.finger_1, scene.dimple.finger_2, scene.dimple.finger_3) if tip]
    keyed = [tip for tip in tips if any(_curves(tip))]
    colliders = _colliders(scene, obj, tips, link.scale) if contact.is_on(scene) else []
    if colliders is None or not (keyed or (colliders and not tips)):
        return None
    if model.free or not _stands(obj) or any(map(_is_led, tips)):
        return None
    paths, now = [_path(scene, tip) for tip in tips], np.array(obj.matrix_world)
    if not np.array_equal(now, link.matrix):  # the object was moved since its session began
        way = link.matrix @ np.linalg.inv(now)
        turn, shift = way[:3, :3].T, link.scale * way[:3, 3]
        paths = [path @ turn + way[:3, 3] for path in paths]
        colliders = [Led(led.points @ turn + shift, led.triangles, led.way @ turn) for led in colliders]
    paths = [link.scale * path for path in paths]
    changes = link.shaped or any(slot.material and any(curve_bags(slot.material)) for slot in obj.material_slots)
    look = 0.0 if changes else timeline.look_s(scene)
    return pressed_by(model.mesh, paths, scene.dimple.finger_radius_mm / 1e3, look, colliders)


def _colliders(
    scene: bpy.types.Scene, obj: bpy.types.Object, tips: list[bpy.types.Object], scale: float
) -> list[Led] | None:
    """Return what an object meets, None where not all of it is known: what is soft or falls goes anywhere."""
    graph, found = bpy.context.evaluated_depsgraph_get(), []
    for other in scene.objects:
        if other == obj or other in tips or other.type != "MESH":
            continue
        if other.dimple.enabled or (other.dimple.collider and other.dimple.is_prop):
            return None
        if not other.dimple.collider or not (evaluated := other.evaluated_get(graph)).is_evaluated:
            continue
        if _is_led(other) or _is_deformed(other):
            return None
        points, triangles = contact.surface(graph, other, scale)
        way = _path(scene, other) - np.array(evaluated.matrix_world.translation)
        found.append(Led(points, triangles, scale * way))
    return found


def _is_deformed(obj: bpy.types.Object) -> bool:
    """Tell whether anything but a change of place may move a mesh: other keyframes, shape keys, what modifiers read."""
    turned = any(curve.data_path != "location" and not curve.mute for bag in curve_bags(obj) for curve in bag.fcurves)
    return turned or bool(obj.data.shape_keys) or any(modifier.type not in STILL for modifier in obj.modifiers)


def _path(scene: bpy.types.Scene, tip: bpy.types.Object) -> Floats:
    """Return the places (k, 3) of a fingertip in the scene, look by look."""
    curves = _curves(tip)
    keys = [point.co.x for curve in curves for point in curve.keyframe_points]
    first, last = min([scene.frame_start, *keys]), max([scene.frame_end, *keys])
    first, looks = math.floor(first), timeline.looks_a_frame(scene)
    frames = first + np.arange((math.floor(last) + 1 - first) * looks + 1) / looks
    own = np.tile(tip.location, (len(frames), 1)).astype(np.float64)
    for curve in curves:
        own[:, curve.array_index] = [curve.evaluate(frame) for frame in frames]
    parent = np.eye(4) if tip.parent is None else np.array(tip.parent.matrix_world @ tip.matrix_parent_inverse)
    return (own + np.array(tip.delta_location)) @ parent[:3, :3].T + parent[:3, 3]


def _curves(obj: bpy.types.Object) -> list[bpy.types.FCurve]:
    """Return the curves that move an object; those that are muted do not."""
    curves = (curve for bag in curve_bags(obj) for curve in bag.fcurves)
    return [curve for curve in curves if curve.data_path == "location" and not curve.mute]


def _is_led(tip: bpy.types.Object) -> bool:
    """Tell whether a fingertip goes where its own keyframes do not say."""
    return _is_driven(tip) or _is_carried(tip)


def _stands(obj: bpy.types.Object) -> bool:
    """Tell whether nothing moves an object but the artist."""
    return not (_is_driven(obj) or any(curve_bags(obj)) or _is_carried(obj))


def _is_carried(obj: bpy.types.Object) -> bool:
    """Tell whether the parent of an object may move it: one that is animated, or a bone or a vertex of any."""
    return bool(obj.parent and (obj.parent_type != "OBJECT" or not _stands(obj.parent)))


def _is_driven(obj: bpy.types.Object) -> bool:
    moved = obj.animation_data
    return bool(obj.constraints or (moved and (moved.drivers or (moved.use_nla and moved.nla_tracks))))
