"""Record live presses at the frame rate of the scene; the object plays the recording once its session has ended."""

from contextlib import ExitStack

import bpy

from ..messages import Note, report
from ..names import Op
from . import polls, sessions


def begin(context: bpy.types.Context) -> None:
    """Start recording every running session, from the current frame of the scene.

    Raises:
        DimpleError: a file cannot be written; nothing is recorded.
    """
    from ..bridge import cache_files, scene_objects
    from . import recorder

    render = context.scene.render
    fps = render.fps / render.fps_base
    begun: list[tuple[sessions.LiveBody, recorder.Recorder]] = []
    with ExitStack() as files, cache_files.plain_os_errors("Recording"):
        for uid, body in sessions.sessions.items():
            obj = scene_objects.find(uid, body.name)
            if obj and not body.recorder:
                each = recorder.Recorder(cache_files.take_path(context, obj), context.scene.frame_current, fps, body)
                files.callback(each.discard)
                begun.append((body, each))
        files.pop_all()
    for body, each in begun:
        body.recorder = each


class DIMPLE_OT_record(polls.Declared, bpy.types.Operator):
    """Record the live press, or stop recording. The object plays the recording once the press has ended"""

    bl_idname = Op.RECORD
    bl_label = "Record"

    needs = (polls.need(lambda _: sessions.sessions, "Poke or play first: there is nothing to record"),)

    def run(self, context: bpy.types.Context) -> None:
        live = sessions.sessions.values()
        if any(body.recording for body in live):  # each object plays its recording once its session has ended
            report(self, [sentence for body in live for sentence in sessions.end_recording(body)])
        else:
            begin(context)
            report(self, [Note("Recording")])
