"""Paint softness from a table of pokes: a vertex group that every vertex gets a weight in."""

import bpy
from bpy.props import StringProperty

from ...core.messages import Message
from ..messages import say
from ..names import Op
from ..press import polls, sessions

GROUP = "Softness from Pokes"
PAINTED = 0.02  # of the vertices may lie beyond what a map can say, before a warning


class DIMPLE_OT_softness_from_pokes(bpy.types.Operator):
    """Paint softness from a table of pokes: x, y, z, depth and force, in places on the object as it stands"""

    bl_idname = Op.SOFTNESS_FROM_POKES
    bl_label = "Softness from Pokes"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(
        name="File", description="Table of pokes: CSV or text", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )
    filter_glob: StringProperty(
        name="Filter", description="Files that are shown", options={"HIDDEN"}, default="*.csv;*.txt;*.tsv"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode and a mesh of this file."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode first")
        return polls.needs_mesh(cls, context) and polls.is_own(cls, context) and polls.is_free(cls)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read, map and paint; nothing is lost where that fails."""
        from ...core.base import DimpleError
        from ...core.calibration.pokes import map_pokes, read_pokes
        from ..bridge import scene_objects, write_back

        body = context.object
        sessions.stop(body.session_uid)
        try:
            pokes = read_pokes(self.filepath)
            link, model = scene_objects.read_body(context, body, baked=False)
            found = map_pokes(model.mesh, model.materials[0], pokes)
        except DimpleError as error:
            say(self, {"ERROR"}, str(error))
            return {"CANCELLED"}
        own = model.mesh.source[scene_objects.nearest_final(link)]
        write_back.paint(body, GROUP, found.weights[own])
        body.dimple.softness_group = GROUP
        say(self, {"INFO"}, found.text)
        if link.cuts:
            say(self, {"WARNING"}, "The mesh has too few vertices to hold the map. Subdivide it first.")
        if found.outside > PAINTED:
            say(self, {"WARNING"}, Message(
                "{outside:.0%} of the vertices are over four times softer or stiffer than the material, beyond "
                "what a map can say: change K1 and K2.",
                outside=found.outside
            ))  # fmt: skip
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_softness_from_pokes])
