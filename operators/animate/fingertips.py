"""Fingertip objects to keyframe: added by hand, or made from the last press."""

import bpy
from mathutils import Vector

from ...core.errors import DimpleError
from ...core.message import Message, in_a_row
from ..bridge import sizing
from ..names import Op
from ..press import fingertip_objects, last_press, polls
from ..reporting import Note, beyond_end, report

STRAIGHT_M = 5e-5  # [m] largest deviation of the keyframed path from the press, at the body's physical size


class DIMPLE_OT_add_fingertip(polls.Declared, bpy.types.Operator):
    """Add a fingertip to the active body."""

    bl_idname = Op.ADD_FINGERTIP
    bl_label = "Add Fingertip"
    bl_description = (
        "Add a fingertip to animate: on top of the active body, or at the 3D cursor if the cursor is on the surface. "
        "Drag its arrow or move it like any object, and press I in the viewport to keyframe it"
    )
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode,
        polls.need(
            lambda context: (body := fingertip_objects.body_of(context.object, context.scene)) and body.type == "MESH",
            "Select the mesh to press",
        ),
        lambda operator, context: polls.has_free_fingertips(operator, context.scene, 1),
    )  # fmt: skip

    def run(self, context: bpy.types.Context) -> None:
        """Add a sphere with the radius of the tool's fingertip that touches the body."""
        from ..bridge import scene_objects

        scene = context.scene
        body = fingertip_objects.body_of(context.object, scene)
        scene_objects.check(body)
        scale, top = scene_objects.scale_and_top(context, body)
        fingertip_objects.leave_poke()
        sizing.fit(scene, body)
        radius = scene.dimple.finger_radius_mm / 1e3 / scale
        place, outward = _at_cursor(context, body, radius) or (Vector(top), Vector((0.0, 0.0, 1.0)))
        number = fingertip_objects.free(scene)[0]
        fingertip_objects.make(context, body, number, place + radius * outward, radius, outward)


def _at_cursor(context: bpy.types.Context, body: bpy.types.Object, near: float) -> tuple[Vector, Vector] | None:
    """Return the point of a body's surface nearest to the 3D cursor, and its normal; None if farther away than `near`.

    A cursor at the origin does not count, because that is its place in a new scene.
    """
    cursor, matrix = context.scene.cursor.location, body.matrix_world
    if not cursor.length or not body.visible_get():
        return None
    evaluated = body.evaluated_get(context.evaluated_depsgraph_get())
    found, point, normal, _ = evaluated.closest_point_on_mesh(matrix.inverted() @ cursor)
    place = matrix @ point
    if not found or (place - cursor).length > near:
        return None
    return place, (matrix.inverted().transposed().to_3x3() @ normal).normalized()


class DIMPLE_OT_key_press(polls.Declared, bpy.types.Operator):
    """Make a keyframed fingertip from the last press."""

    bl_idname = Op.KEY_PRESS
    bl_label = "Key This Press"
    bl_description = (
        "Turn the last press by mouse, pen or haptic device into a keyframed fingertip, from the current frame on. A "
        "bake then repeats the motion that you saw"
    )
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode,
        polls.need(lambda context: _wanted(context), "Press a body first: there is nothing to keyframe"),
        lambda operator, context: polls.has_free_fingertips(operator, context.scene, len(_wanted(context).ways)),
        polls.is_free,
    )

    def run(self, context: bpy.types.Context) -> None:
        from ..bridge import object_link

        press, scene = _wanted(context), context.scene
        body = object_link.find(press.uid, press.name)
        if body is None:
            raise DimpleError('"{name}" is gone.', name=press.name)
        fingertip_objects.leave_poke()
        first, last = key(context, press, body)
        said = Message(
            'The press on "{name}" is keyframed from frame {first} to {last}.', name=body.name, first=first, last=last
        )
        beyond = beyond_end(last, scene.frame_end)
        report(self, [in_a_row([said, *beyond]) if beyond else Note(said)])


def key(context: bpy.types.Context, press: last_press.LivePress, body: bpy.types.Object) -> tuple[int, int]:
    """Add keyframed fingertips that repeat a press, and return its first and last frame."""
    from ...core.poke.stroke import keys
    from ..bridge import keyframes, timeline

    scene = context.scene
    frame, frame_s = scene.frame_current if press.frame is None else press.frame, timeline.frame_s(scene)
    tips, shown = [], []
    for number, way in zip(fingertip_objects.free(scene), press.ways.values(), strict=False):
        frames, places = keys(way, press.start, frame, frame_s, STRAIGHT_M)
        places /= press.scale
        tip = fingertip_objects.make(context, body, number, places[0, :3], places[0, 3], way.outward)
        resized = any(places[:, 3] != places[0, 3])
        for at, place in zip(frames.tolist(), places, strict=True):
            tip.location = place[:3]
            tip.keyframe_insert("location", frame=at)
            if resized:
                tip.scale = [place[3] / places[0, 3]] * 3
                tip.keyframe_insert("scale", frame=at)
        for bag in keyframes.curve_bags(tip):
            for curve in bag.fcurves:
                keyframes.straighten(curve)
        tips.append(tip)
        shown += [int(frames[0]), int(frames[-1])]
    for tip in tips:
        tip.select_set(True)
    scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)  # moves them to their place at this frame
    return min(shown), max(shown)


def _wanted(context: bpy.types.Context) -> last_press.LivePress | None:
    """Return the last press on the active body, or on the body that the active fingertip presses."""
    return last_press.last(context.scene, fingertip_objects.body_of(context.object, context.scene))
