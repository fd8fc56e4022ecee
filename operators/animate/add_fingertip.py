"""A fingertip to keyframe: an object that presses."""

import bpy
from mathutils import Vector

from ..bridge import sizing
from ..messages import report
from ..names import Op
from ..press import fingertip_objects, polls


class DIMPLE_OT_add_fingertip(polls.Declared, bpy.types.Operator):
    """Add a fingertip to the active body."""

    bl_idname = Op.ADD_FINGERTIP
    bl_label = "Add Fingertip"
    bl_description = (
        "Add a fingertip to animate: on top of the active body, or at the 3D cursor if that is on its surface. "
        "Drag its arrow, or move it like any object, and press I over the viewport to keyframe it"
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
        """Add a sphere as large as the tool's fingertip, touching the body."""
        from ..bridge import scene_objects

        scene = context.scene
        body = fingertip_objects.body_of(context.object, scene)
        scene_objects.check(body)
        scale, top = scene_objects.scale_and_top(context, body)
        report(self, fingertip_objects.leave_poke())
        sizing.fit(scene, body)
        radius = scene.dimple.finger_radius_mm / 1e3 / scale
        place, outward = _at_cursor(context, body, radius) or (Vector(top), Vector((0.0, 0.0, 1.0)))
        number = fingertip_objects.free(scene)[0]
        fingertip_objects.make(context, body, number, place + radius * outward, radius, outward)


def _at_cursor(context: bpy.types.Context, body: bpy.types.Object, near: float) -> tuple[Vector, Vector] | None:
    """Return where the surface of a body is nearest to the 3D cursor and its unit normal; None if that is not near.

    A cursor at the origin was not put there: that is where it is in a new scene.
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
