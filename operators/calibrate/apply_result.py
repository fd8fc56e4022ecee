"""From a result in the scene to the constants of a material."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty

from ...core.messages import kept
from ..bridge import sizing
from ..names import Op
from ..press import polls
from . import results
from .apply_preset import material_of


class DIMPLE_OT_apply_calibration(bpy.types.Operator):
    """Give the active material the calibrated constants and their source, and the body its measured size"""

    bl_idname = Op.APPLY_CALIBRATION
    bl_label = "Apply to Material"
    bl_options = {"REGISTER", "UNDO"}

    use_k: BoolProperty(
        name="Surface Spring", description="Also set k, where it follows from the size of the object", default=True
    )
    use_damping: BoolProperty(
        name="Damping Ratio", description="Also set the damping ratio, where it follows from the unloading curve",
        default=True,
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a mesh and a result that can be a material."""
        record = results.load(context.scene.dimple.calibration)
        if not record:
            return polls.refuse(cls, "Calibrate with a file first")
        if record["unusable"]:
            return polls.refuse(cls, "There is no material with these constants")
        if not polls.needs_mesh(cls, context):
            return False
        if context.object.active_material and context.object.active_material.library:
            return polls.refuse(cls, "The material is linked from another file: make it local first")
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set constants, tip, size and source."""
        scene, body = context.scene.dimple, context.object
        record = results.load(scene.calibration)
        settings = material_of(body, Path(record["source"]).stem).dimple
        settings.K1, settings.K2, settings.x0 = record["K1"], record["K2"], record["x0"]
        k = record["source_of_k"] if self.use_k else ""
        if k:
            settings.k = record["k_to_use"]
        if self.use_damping and record["damping_ratio_hint"] is not None:
            settings.damping_ratio = record["damping_ratio_hint"]
        settings.tip, settings.tip_radius_mm = record["tip"].upper(), record["tip_radius"]
        settings.calibration, scene.calibration = scene.calibration, ""
        settings.provenance = kept(results.source(record, k))  # last: a constant that is set marks it as edited
        body.dimple.enabled = True
        if record["length"]:
            body.dimple.size_mode, body.dimple.size_mm = "CUSTOM", record["length"]
            sizing.fit(context.scene, body)
        return {"FINISHED"}


class DIMPLE_OT_discard_calibration(bpy.types.Operator):
    """Discard the result of the calibration; materials do not change"""

    bl_idname = Op.DISCARD_CALIBRATION
    bl_label = "Discard"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a result."""
        return bool(context.scene.dimple.calibration)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Discard it."""
        context.scene.dimple.calibration = ""
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_apply_calibration, DIMPLE_OT_discard_calibration])
