"""A fingertip to keyframe: an object that presses."""

import bpy

from . import polls
from .messages import say
from .names import Op


class DIMPLE_OT_add_fingertip(bpy.types.Operator):
    """Add a fingertip above the active object: an object that presses, to be moved and keyframed"""

    bl_idname = Op.ADD_FINGERTIP
    bl_label = "Add Fingertip"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, a mesh and a free slot."""
        settings = context.scene.dimple
        if context.mode != "OBJECT" or context.object is None or context.object.type != "MESH":
            return polls.refuse(cls, "Select the mesh to press, in Object Mode")
        if settings.finger_1 and settings.finger_2 and settings.finger_3:
            return polls.refuse(cls, "All three fingertips are in use; take one out of its slot first")
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add an empty as large as the fingertip, touching the top of the body."""
        from ..core.base import DimpleError
        from . import bridge

        body, settings = context.object, context.scene.dimple
        try:
            bridge.check(body)
            scale, top = bridge.scale_and_top(context, body)
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        number = next(n for n in (1, 2, 3) if not getattr(settings, f"finger_{n}"))
        tip = bpy.data.objects.new(f"Fingertip {number}", None)
        radius = settings.finger_radius_mm / 1e3 / scale
        tip.empty_display_type, tip.empty_display_size = "SPHERE", radius
        tip.location = (top[0], top[1], top[2] + radius)
        context.collection.objects.link(tip)
        setattr(settings, f"finger_{number}", tip)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_add_fingertip])
