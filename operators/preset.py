"""Materials of measured objects, and fingertips to keyframe."""

import bpy
from bpy.props import StringProperty

from . import polls
from .names import Op


def material_of(obj: bpy.types.Object, name: str) -> bpy.types.Material:
    """Return the active material of a mesh; a new one where there is none."""
    if obj.active_material is None:
        obj.active_material = bpy.data.materials.new(name)
    return obj.active_material


class DIMPLE_OT_apply_preset(bpy.types.Operator):
    """Give the active material the constants of a measured object, and the body its measured size"""

    bl_idname = Op.APPLY_PRESET
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(name="Preset", description="Name of a measured object, such as object_2_vinyl_air")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a mesh whose settings stay: those of linked data are lost with the file."""
        return polls.needs_mesh(cls, context) and polls.is_own(cls, context.object)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set material, size and source."""
        from ..core.material import PRESETS

        preset = next((each for each in PRESETS if each.name == self.preset), None)
        if preset is None:
            known = ", ".join(each.name for each in PRESETS)
            self.report({"ERROR"}, f'There is no preset "{self.preset}". There are: {known}.')
            return {"CANCELLED"}
        constants, settings = preset.material, material_of(context.object, preset.label).dimple
        settings.K1, settings.K2, settings.k = constants.K1 / 1e3, constants.K2 / 1e3, constants.k / 1e3
        settings.x0 = constants.x0 * 1e3
        if constants.mass is not None:
            settings.mass_from, settings.mass_kg = "MASS", constants.mass
        else:
            settings.mass_from, settings.density = "DENSITY", constants.density
        settings.damping_ratio, settings.friction = constants.damping_ratio, constants.friction
        settings.fill = constants.fill.upper()
        settings.tip, settings.tip_radius_mm, settings.calibration = "POINT", 2.0, ""
        settings.provenance = preset.provenance  # last: a constant that is set marks the material as edited
        body = context.object.dimple
        body.enabled, body.size_mode, body.size_mm = True, "CUSTOM", preset.size * 1e3
        return {"FINISHED"}


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
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        number = next(n for n in (1, 2, 3) if not getattr(settings, f"finger_{n}"))
        tip = bpy.data.objects.new(f"Fingertip {number}", None)
        radius = settings.finger_radius_mm / 1e3 / scale
        tip.empty_display_type, tip.empty_display_size = "SPHERE", radius
        tip.location = (top[0], top[1], top[2] + radius)
        context.collection.objects.link(tip)
        setattr(settings, f"finger_{number}", tip)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_apply_preset, DIMPLE_OT_add_fingertip])
