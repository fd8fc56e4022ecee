"""A fingertip to keyframe: an object that presses."""

import bpy
from mathutils import Vector

from . import fingertip_objects, polls, sizing
from .messages import report, say
from .names import Op


class DIMPLE_OT_add_fingertip(bpy.types.Operator):
    """Add a fingertip to the active body."""

    bl_idname = Op.ADD_FINGERTIP
    bl_label = "Add Fingertip"
    bl_description = (
        "Add a fingertip to animate: on top of the active body, or at the 3D cursor if that is on its surface. "
        "Drag its arrow, or move it like any object, and press I over the viewport to keyframe it"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, a mesh and a free slot."""
        body = fingertip_objects.body_of(context.object, context.scene)
        if context.mode != "OBJECT" or body is None or body.type != "MESH":
            return polls.refuse(cls, "Select the mesh to press, in Object Mode")
        return polls.has_free_fingertips(cls, context.scene, 1)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add a sphere as large as the tool's fingertip, touching the body."""
        from ..core.base import DimpleError
        from . import bridge

        scene = context.scene
        body = fingertip_objects.body_of(context.object, scene)
        try:
            bridge.check(body)
            scale, top = bridge.scale_and_top(context, body)
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        report(self, fingertip_objects.leave_poke())
        sizing.fit(scene, body)
        radius = scene.dimple.finger_radius_mm / 1e3 / scale
        place, outward = _at_cursor(context, body, radius) or (Vector(top), Vector((0.0, 0.0, 1.0)))
        number = fingertip_objects.free(scene)[0]
        fingertip_objects.make(context, body, number, place + radius * outward, radius, outward)
        return {"FINISHED"}


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


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_add_fingertip])
