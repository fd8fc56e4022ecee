"""The virtual press: press the active body with a round tip and write the file that an instrument would write."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ...core.message import Message, about
from ..names import PLACES, Op
from ..press import polls, sessions
from ..press.progress import Working
from ..reporting import say
from . import results
from .from_file import Saved, shown_files

BEYOND = 1.5  # [knee depths] depth of the press if that of the measurement is unknown


class DIMPLE_OT_measure(Working, Saved, bpy.types.Operator):
    """Press the active object with a round tip, virtually, and write force against depth as a CSV file"""

    bl_idname = Op.MEASURE
    bl_label = "Measure"
    filename_ext = ".csv"
    verb, stopped = "Measuring", "The measurement was stopped; nothing was written"
    asked = "filepath", "tip_radius_mm", "place", "depth_mm", "rows"

    filter_glob: shown_files("*.csv")
    tip_radius_mm: FloatProperty(
        name="Tip Radius (mm)", description="Radius of the tip; 0 uses the tip that measured the material",
        default=0.0, min=0.0, soft_max=50.0,
    )  # fmt: skip
    place: EnumProperty(name="Press At", description="Where the tip presses", items=PLACES)
    depth_mm: FloatProperty(
        name="Depth (mm)", description="How deep to press; 0 is the depth to which the material was measured",
        default=0.0, min=0.0, soft_max=200.0,
    )  # fmt: skip
    rows: IntProperty(name="Rows", description="Rows of the file", default=60, min=12, soft_max=300)

    needs = polls.in_object_mode, polls.can_be_pressed, polls.is_free

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file, then measure between Blender's events."""
        if self.properties.is_property_set("filepath"):
            return Working.invoke(self, context, event)
        self.filepath = bpy.path.clean_name(context.object.name) + self.filename_ext
        self.browsing = True
        return Saved.invoke(self, context, event)

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw tip, place, depth and number of rows."""
        layout = self.layout
        layout.use_property_split = True
        for name in self.asked[1:]:
            layout.prop(self, name)

    def _begin(self, context: bpy.types.Context):
        """Return the steps of the measurement; live sessions end first, because it starts at rest."""
        from ...core.base import DimpleError
        from ...core.calibration.virtual_press import find_site, press_rows
        from ..bridge import scene_objects

        if not self.filepath:
            raise DimpleError("Choose a path for the file.")
        sessions.stop_all()
        body = context.object
        link, model = scene_objects.read_body(context, body)
        if model.free and model.ground is None:
            raise DimpleError(
                'Nothing holds "{name}", so the tip would push it away. Pin its base.', name=body.name
            )
        slot = link.slots.index(body.active_material_index) if body.active_material_index in link.slots else 0
        material = model.materials[slot]
        radius = self.tip_radius_mm / 1e3 or material.indenter.radius
        place = self.place if self.properties.is_property_set("place") else context.scene.dimple.tip_place
        try:
            site = find_site(model.mesh, *(_at_cursor(context, link.scale, model.mesh) if place == "CURSOR" else ()))
        except DimpleError as error:
            raise DimpleError(about(body.name, str(error))) from error
        settings = body.active_material and body.active_material.dimple
        measured = results.load(settings.calibration).get("deepest", 0.0) if settings else 0.0
        self._deepest = (self.depth_mm or measured) / 1e3 or BEYOND * material.x0
        self._about = [
            f"Simulated by Dimple, not measured: {body.name}, {1e3 * model.mesh.size:.4g} mm",
            f"Tip: sphere, radius {1e3 * radius:.4g} mm",
            f"Material: K1 {material.K1 / 1e3:.4g} N/mm, K2 {material.K2 / 1e3:.4g} N/mm, "
            f"x0 {material.x0 * 1e3:.4g} mm",
        ]
        return self._steps_of(press_rows(model, radius, site, self._deepest, self.rows))

    def _steps_of(self, rows):
        self._rows = []
        for row in rows:
            self._rows.append(row)
            yield min(len(self._rows) / self.rows, 0.999)

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        """Write the file."""
        import numpy as np

        from ...core.calibration.virtual_press import write_press

        depth, force = np.array(self._rows).T
        path = bpy.path.ensure_ext(bpy.path.abspath(self.filepath), self.filename_ext)
        write_press(path, depth, force, about=self._about)
        deepest, wanted = float(depth[-1]), self._deepest
        if deepest < 0.999 * wanted:
            why = Message("the body is too thin, or gives way")
            say(self, {"WARNING"}, Message(
                "Pressed {depth:.3g} mm deep instead of {wanted:.3g} mm: {why}",
                depth=1e3 * deepest, wanted=1e3 * wanted, why=why
            ))  # fmt: skip
        say(self, {"INFO"}, Message(
            "Measured to a depth of {depth:.3g} mm, with up to {force:.3g} N: {path}",
            depth=1e3 * deepest, force=force.max(), path=path
        ))  # fmt: skip
        return {"FINISHED"}


def _at_cursor(context: bpy.types.Context, scale: float, mesh):
    """Return the point (3,) [m] of the surface nearest to the 3D cursor, and the inward normal there."""
    from mathutils.bvhtree import BVHTree

    tree = BVHTree.FromPolygons(mesh.rest_positions.tolist(), mesh.triangles.tolist())
    point, normal, _, _ = tree.find_nearest(scale * context.scene.cursor.location)
    return point, -normal
