"""Apply the calibration result in the scene to a material."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty

from ...core.message import kept
from ..bridge import sizing
from ..bridge.material_presets import material_of
from ..names import Op
from ..press import polls
from . import results


def _result(context: bpy.types.Context) -> dict:
    return results.load(context.scene.dimple.calibration)


has_result = polls.need(_result, "Calibrate with a file first")


class DIMPLE_OT_apply_calibration(polls.Declared, bpy.types.Operator):
    """Give the active material the calibrated constants and their source, and set the size of the body"""

    bl_idname = Op.APPLY_CALIBRATION
    bl_label = "Apply to Material"
    bl_options = {"REGISTER", "UNDO"}

    use_k: BoolProperty(
        name="Surface Spring", default=True,
        description="Also set k, from which the spread then follows. Needs the size of the object",
    )  # fmt: skip
    use_damping: BoolProperty(
        name="Damping Ratio", description="Also set the damping ratio, if the file has an unloading curve",
        default=True,
    )  # fmt: skip

    needs = (
        has_result,
        polls.need(lambda context: _result(context)["K1"] > 0, "No material has these constants"),
        polls.needs_mesh,
        polls.is_own,
    )

    def run(self, context: bpy.types.Context) -> None:
        scene, body = context.scene.dimple, context.object
        record = results.load(scene.calibration)
        settings = material_of(body, Path(record["source"]).stem).dimple
        settings.K1, settings.K2, settings.x0 = record["K1"], record["K2"], record["x0"]
        k = record["source_of_k"] if self.use_k else ""
        if k:
            settings.k, settings.spread_mm = record["k"], 0.0  # k decides how far a dent reaches
        if self.use_damping and record["damping_ratio_hint"] is not None:
            settings.damping_ratio = record["damping_ratio_hint"]
        settings.tip, settings.tip_radius_mm = record["tip"].upper(), record["tip_radius"]
        settings.calibration, scene.calibration = scene.calibration, ""
        settings.provenance = kept(results.source(record, k))  # last: setting a constant marks it as edited
        body.dimple.enabled = True
        if record["length"]:
            body.dimple.size_mode, body.dimple.size_mm = "CUSTOM", record["length"]
            sizing.fit(context.scene, body)


class DIMPLE_OT_discard_calibration(polls.Declared, bpy.types.Operator):
    """Discard the result of the calibration; materials do not change"""

    bl_idname = Op.DISCARD_CALIBRATION
    bl_label = "Discard"
    bl_options = {"REGISTER", "UNDO"}

    needs = (has_result,)

    def run(self, context: bpy.types.Context) -> None:
        context.scene.dimple.calibration = ""
