"""The experiment itself: press the selected body with the measuring tip and write what an instrument would."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import modal_runs, polls, sessions
from .identify import place_of
from .messages import say
from .names import PLACES, TIPS, Op
from .working import Working

_AS_MEASURED = ("MEASURED", "As Measured", "The tip that measured the material; any other is a prediction")


class DIMPLE_OT_measure(Working, bpy.types.Operator):
    """Press the active object with its measuring tip, virtually, and write force against depth as a CSV file"""

    bl_idname = Op.MEASURE
    bl_label = "Measure"
    verb, stopped = "Measuring", "The measurement was stopped; nothing was written"

    filepath: StringProperty(name="File", description="Where the CSV goes", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(name="Filter", description="Files that are shown", options={"HIDDEN"}, default="*.csv")
    check_existing: BoolProperty(
        name="Check Existing", description="Ask before a file is overwritten", options={"HIDDEN"}, default=True
    )
    tip: EnumProperty(name="Tip", description="What presses the object", items=(_AS_MEASURED, *TIPS))
    tip_radius_mm: FloatProperty(
        name="Tip Radius (mm)", description="Radius of what presses, where it is not the tip that measured",
        default=10.0, min=0.01, soft_max=50.0,
    )  # fmt: skip
    place: EnumProperty(name="Press At", description="Where the tip presses", items=PLACES)
    depth_mm: FloatProperty(
        name="Depth (mm)", description="How deep to press; 0 is the measured depth",
        default=0.0, min=0.0, soft_max=200.0,
    )  # fmt: skip
    rows: IntProperty(name="Rows", description="Rows of the file", default=60, min=12, soft_max=300)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode, a mesh with a material, and nothing else at work."""
        return polls.can_measure(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file, then measure between Blender's events."""
        if self.properties.is_property_set("filepath"):
            return Working.invoke(self, context, event)
        self.filepath = f"{bpy.path.clean_name(context.object.name)}.csv"
        self._browsing = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Measure at once; behind the file browser start anew, for this one cannot go on between events."""
        if getattr(self, "_browsing", False):
            given = self.properties.is_property_set
            settings = {name: getattr(self, name) for name in _ASKED if given(name)}
            bpy.ops.dimple.measure("INVOKE_DEFAULT", filepath=self.filepath, **settings)
            return {"CANCELLED"}
        return Working.execute(self, context)

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw how deep, in how many rows and where."""
        layout = self.layout
        layout.use_property_split = True
        for name in _ASKED:
            row = layout.row()
            row.active = name != "tip_radius_mm" or self.tip != _AS_MEASURED[0]
            row.prop(self, name)

    def _open(self, context: bpy.types.Context) -> modal_runs.ModalRun:
        return modal_runs.open_run(context, "measure", "Measuring: Esc cancels", interval=0.01)

    def _begin(self, context: bpy.types.Context):
        """Return the steps; a body is at rest before it is pressed."""
        from ..core.base import DimpleError
        from ..core.material import Indenter
        from . import indentation

        if not self.filepath:
            raise DimpleError("Say where the file goes: give it a path.")
        sessions.stop_all()
        other = self.tip != _AS_MEASURED[0]
        tip = Indenter(shape=self.tip.lower(), radius=self.tip_radius_mm / 1e3) if other else None
        self._bench = indentation.set_up(context, context.object, place_of(self, context), self.depth_mm, tip)
        return self._steps_of(self._bench)

    def _steps_of(self, bench):
        import numpy as np

        from ..core.base import DimpleError
        from ..core.calibration.indent import press_rows

        found, given = [], (bench.mesh, bench.material, bench.indenter, bench.site, bench.deepest)
        for row in press_rows(*given, rows=self.rows):
            found.append(row)
            yield min(len(found) / self.rows, 0.999)
        if len(found) < 12:
            way_out = "Press elsewhere." if bench.material.constants else "Identify it first: its skin is an estimate."
            raise DimpleError(
                f"The body finds no rest deeper than {1e3 * found[-1][0]:.3g} mm: nothing was written. {way_out}"
            )
        self._curve = np.array(found).T

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        """Write the file."""
        from ..core.calibration.export import write_press

        depth, force = self._curve
        path = bpy.path.ensure_ext(bpy.path.abspath(self.filepath), ".csv")
        write_press(path, depth, force, about=_about(self._bench))
        deepest, wanted = float(depth[-1]), self._bench.deepest
        if deepest < 0.999 * wanted:
            why = "the body is no thicker, or finds no rest"
            say(self, {"WARNING"}, f"Pressed {1e3 * deepest:.3g} mm of {1e3 * wanted:.3g} mm deep: {why} deeper")
        for note in self._bench.notes:
            say(self, {"WARNING"}, note)
        say(self, {"INFO"}, f"Measured {1e3 * deepest:.3g} mm deep with up to {force.max():.3g} N: {path}")
        return {"FINISHED"}


_ASKED = ("tip", "tip_radius_mm", "place", "depth_mm", "rows")


def _about(bench) -> list[str]:
    """Return the lines above the table: what was pressed, with what, and that it was a simulation."""
    tip = f"{bench.indenter.shape}, radius {1e3 * bench.indenter.radius:.4g} mm"
    identified = "identified on its mesh" if bench.material.constants else "estimated"
    m = bench.material
    return [
        f"Simulated by Dimple, not measured: {bench.link.name}, {1e3 * bench.mesh.size:.4g} mm",
        f"Tip: {tip}",
        f"Material: K1 {m.K1 / 1e3:.4g} N/mm, K2 {m.K2 / 1e3:.4g} N/mm, x0 {m.x0 * 1e3:.4g} mm; "
        f"model constants {identified}",
    ]


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_measure])
