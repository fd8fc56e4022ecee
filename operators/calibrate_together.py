"""Several files of one object, measured with different tips or at several places, to one result in the scene."""

import re
from pathlib import Path

import bpy
from bpy.props import CollectionProperty, EnumProperty, FloatProperty, StringProperty

from ..core.messages import Message
from . import calibration, polls
from .messages import say
from .names import TIPS, Op

# as people name their files: ball_10mm.csv, punch-r5.txt, sphere 2.5 mm.csv
_SHAPES = {"ball": "SPHERE", "sphere": "SPHERE", "punch": "PUNCH", "flat": "PUNCH", "point": "POINT"}
_RADIUS = re.compile(r"(\d+(?:\.\d+)?)\s*mm|\br(\d+(?:\.\d+)?)", re.IGNORECASE)
WIDTH = 520  # [px] of the dialog


class DIMPLE_PG_curve_file(bpy.types.PropertyGroup):
    """One file, and the tip that measured it."""

    tip: EnumProperty(name="Tip", description="What pressed the object", items=TIPS, default="SPHERE")
    tip_radius_mm: FloatProperty(
        name="Tip Radius (mm)", description="Radius of what pressed the object", default=10.0, min=0.01, soft_max=50.0
    )


class DIMPLE_OT_calibrate_together(bpy.types.Operator):
    """Fit one material to several force-depth files of one object; tips of different radius determine the spread"""

    bl_idname = Op.CALIBRATE_TOGETHER
    bl_label = "Calibrate Together"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(
        name="Folder", description="Where the files are", subtype="DIR_PATH", options={"SKIP_SAVE"}
    )
    files: CollectionProperty(name="Files", type=DIMPLE_PG_curve_file, options={"SKIP_SAVE"})
    filter_glob: StringProperty(
        name="Filter", description="Files that are shown", options={"HIDDEN"},
        default=calibration.FILTER,
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode: the result is one undo step there."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode to calibrate")
        return True

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Ask for the files, then for the tip of each; a name that says its tip is believed until it is changed."""
        if not self.files:
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        for each in self.files:
            if not each.is_property_set("tip_radius_mm"):
                tip_from_name(each)
        return context.window_manager.invoke_props_dialog(self, width=WIDTH)

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw each file with its tip."""
        for each in self.files:
            row = self.layout.row(align=True)
            row.label(text=each.name, icon="FILE_TEXT", translate=False)
            row.prop(each, "tip", text="")
            row.prop(each, "tip_radius_mm")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read and fit; nothing is lost where that fails."""
        from ..core.base import DimpleError
        from ..core.calibration.together import curve_of, fit_together, lines

        body = context.object
        length = body.dimple.size_mm / 1e3 if body and body.dimple.size_mode == "CUSTOM" else None
        try:
            alone = [self._alone(each, length) for each in self.files]
            found = fit_together([curve_of(each) for each in alone], size=length or 0.0)
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        context.scene.dimple.calibration = calibration.joint_text(alone[0], found)
        first, *rest = lines(found)
        say(self, {"INFO"}, first)
        say(self, {"INFO" if found.determined else "WARNING"}, rest[0])
        return {"FINISHED"}

    def _alone(self, each: DIMPLE_PG_curve_file, length: float | None):
        """Return the calibration of one file.

        Raises:
            DimpleError: it cannot be used as it is, with what to do.
        """
        from ..core.base import DimpleError
        from ..core.calibration.calibrate import calibrate
        from ..core.calibration.question import Undecided
        from ..core.material import Indenter

        tip = Indenter(shape=each.tip.lower(), radius=each.tip_radius_mm / 1e3)
        try:
            return calibrate(Path(self.directory) / each.name, tip=tip, length=length)
        except Undecided as undecided:
            asked = undecided.questions[0].text
            raise DimpleError(
                "{name} is ambiguous: {asked} Calibrate from this file alone to answer, or state it in its header.",
                name=each.name, asked=Message(asked)
            ) from None  # fmt: skip


def tip_from_name(each: DIMPLE_PG_curve_file) -> None:
    """Set the tip that the name of a file says, where it says one."""
    stem = Path(each.name).stem.lower()
    if shape := next((shape for word, shape in _SHAPES.items() if word in stem), None):
        each.tip = shape
    if found := _RADIUS.search(stem.replace("_", " ").replace("-", " ")):
        each.tip_radius_mm = float(found[1] or found[2])


def several(operator: bpy.types.Operator) -> set[str] | None:
    """Hand several files that were dropped at once on; None where there is one."""
    if len(operator.files) < 2:
        return None
    files = [{"name": each.name} for each in operator.files]
    bpy.ops.dimple.calibrate_together("INVOKE_DEFAULT", directory=operator.directory, files=files)
    return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_PG_curve_file, DIMPLE_OT_calibrate_together])
