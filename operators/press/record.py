"""Record live presses at the frame rate of the scene; the object plays the recording once its session has ended."""

import bpy

from ...core.errors import DimpleError
from ..messages import Note, report
from ..names import Op
from . import polls, sessions


def begin(context: bpy.types.Context) -> None:
    """Start to record every running session, from the current frame of the scene.

    Raises:
        DimpleError: a file cannot be written; nothing is recorded.
    """
    from ..bridge import cache_files, scene_objects
    from . import recorder

    render = context.scene.render
    fps = render.fps / render.fps_base
    begun: list[tuple[sessions.LiveBody, recorder.Recorder]] = []
    try:
        for uid, body in sessions.sessions.items():
            obj = scene_objects.find(uid, body.name)
            if obj is None or body.recorder:
                continue
            path = cache_files.take_path(context, obj)
            with cache_files.plain_os_errors("Recording"):
                each = recorder.Recorder(path, context.scene.frame_current, fps, body)
            begun.append((body, each))
    except DimpleError:
        for _, each in begun:
            each.discard()
        raise
    for body, each in begun:
        body.recorder = each


def end() -> list[str]:
    """Stop recording; each object plays its take once its session has ended. Return sentences for the artist."""
    return [sentence for body in sessions.sessions.values() for sentence in sessions.end_recording(body)]


def switch(context: bpy.types.Context) -> list[str]:
    """Begin to record, or end it; return sentences for the artist.

    Raises:
        DimpleError: nothing can be recorded.
    """
    if any(body.recording for body in sessions.sessions.values()):
        return end()
    begin(context)
    return [Note("Recording")]


class DIMPLE_OT_record(polls.Declared, bpy.types.Operator):
    """Record the live press, or stop recording. The object plays the recording once the press has ended"""

    bl_idname = Op.RECORD
    bl_label = "Record"

    needs = (polls.need(lambda _: sessions.sessions, "Poke or play first: there is nothing to record"),)

    def run(self, context: bpy.types.Context) -> None:
        """Start or stop."""
        report(self, switch(context))


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_record])
