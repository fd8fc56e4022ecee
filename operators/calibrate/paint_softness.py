"""Paint softness from a table of pokes, as a vertex group with a weight for every vertex."""

import bpy

from ...core.message import Message
from ..names import Op
from ..press import polls, sessions
from ..reporting import say
from .from_file import Opened, shown_files

GROUP = "Softness from Pokes"
PAINTED = 0.02  # fraction of the vertices that may lie outside the range of a map before a warning


class DIMPLE_OT_softness_from_pokes(Opened, polls.Declared, bpy.types.Operator):
    """Paint softness from a table of pokes: x, y, z, depth and force, at positions on the object as it stands"""

    bl_idname = Op.SOFTNESS_FROM_POKES
    bl_label = "Softness from Pokes"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: shown_files("*.csv;*.txt;*.tsv")

    needs = polls.in_object_mode, polls.needs_mesh, polls.is_own, polls.is_free

    def run(self, context: bpy.types.Context) -> None:
        from ...core.calibration.pokes import map_pokes, read_pokes
        from ..bridge import scene_objects, write_back

        body, manager = context.object, context.window_manager
        sessions.stop(body.session_uid)
        pokes = read_pokes(self.filepath)
        link, model = scene_objects.read_body(context, body)
        manager.progress_begin(0, 1)
        try:
            found = map_pokes(model.mesh, model.materials[0], pokes, manager.progress_update)
        finally:
            manager.progress_end()
        own = model.mesh.source[scene_objects.nearest_final(link)]
        write_back.paint(body, GROUP, found.weights[own])
        body.dimple.softness_group = GROUP
        say(self, {"INFO"}, found.text)
        if link.cuts:
            say(self, {"WARNING"}, "The mesh has too few vertices to hold the map. Subdivide it first.")
        if found.outside > PAINTED:
            said = "{outside:.0%} of the vertices are over 4 times softer or stiffer than the material: edit K1 and K2."
            say(self, {"WARNING"}, Message(said, outside=found.outside))
