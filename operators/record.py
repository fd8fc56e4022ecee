"""Record what is pressed live, at the frame rate of the scene; when the session ends the object plays it."""

import bpy

from . import polls, sessions
from .names import Op


def begin(context: bpy.types.Context) -> None:
    """Start to record every running session, from the current frame of the scene.

    Raises:
        DimpleError: the file cannot be written.
    """
    from . import bridge, output

    render = context.scene.render
    for uid, body in sessions.sessions.items():
        obj = bridge.find(uid, body.name)
        if obj is None or body.recorder:
            continue
        path = output.cache_path(context, obj, "take")
        local = bridge.to_local(body.link, body.matrix, body.session.positions())
        with output.plain_os_errors("Recording"):
            body.recorder = output.Recorder(
                path, context.scene.frame_current, render.fps / render.fps_base, body.frame.time, local, body.frame
            )


def end() -> None:
    """Stop recording; each object plays its take once its session has ended."""
    for body in sessions.sessions.values():
        if body.recorder:
            body.take, body.recorder = body.recorder.close(), None


class DIMPLE_OT_record(bpy.types.Operator):
    """Record what is being pressed, or stop; the object plays it once its session has ended"""

    bl_idname = Op.RECORD
    bl_label = "Record"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Need a session."""
        if not sessions.sessions:
            return polls.refuse(cls, "Poke or play first: there is nothing to record")
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Start or stop."""
        from ..core.base import DimpleError

        if any(body.recording for body in sessions.sessions.values()):
            end()
            self.report({"INFO"}, "Recorded. The object plays it when the session ends")
            return {"FINISHED"}
        try:
            begin(context)
        except DimpleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, "Recording")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_record])
