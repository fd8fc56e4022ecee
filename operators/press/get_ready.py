"""Get large meshes ready between Blender's events, with a progress bar; then poke or play."""

import bpy
from bpy.props import StringProperty

from ..messages import report
from ..names import Op
from . import sessions
from .progress import Working

LARGE = 20_000  # vertices in all: more take longer than a second, so they are read beside Blender's events


class DIMPLE_OT_start(Working, bpy.types.Operator):
    """Get the selected meshes ready to be pressed, then poke or play"""

    bl_idname = Op.START
    bl_label = "Get Ready"
    bl_options = {"INTERNAL"}
    running = "Getting ready: Esc cancels"
    verb, stopped = "Getting ready", "Nothing was started"
    ready = 1.0  # how long the parts take is not known

    then: StringProperty(name="Then", description="The operator that follows", options={"HIDDEN", "SKIP_SAVE"})

    def _begin(self, context: bpy.types.Context):
        from ...core.steps import beside
        from . import live_step

        self._came = yield from beside(live_step.starting_all(context))

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        _, messages, wrong = self._came
        report(self, [*wrong, *messages])
        getattr(bpy.ops.dimple, self.then)("INVOKE_DEFAULT")
        return {"FINISHED"}


def takes_long(context: bpy.types.Context) -> bool:
    """Tell whether what would be started is large, and does not run yet.

    Raises:
        DimpleError: nothing can be started.
    """
    from . import live_step

    graph = context.evaluated_depsgraph_get()
    waiting = [obj for obj in live_step.candidates(context) if obj.type == "MESH" and sessions.get(obj) is None]
    return sum(len(obj.evaluated_get(graph).data.vertices) for obj in waiting) > LARGE


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_start])
