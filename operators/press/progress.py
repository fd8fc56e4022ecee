"""What takes more than a second: at once from a script, else between Blender's events, with the time left."""

import time

import bpy
from bpy.props import IntProperty

from ...core.messages import Message
from ..messages import conclude, duration, say
from ..translation import translated
from . import modal_runs, sessions

SLICE_S = 0.1  # between two looks at the keyboard
READY = 0.05  # of a bake, for getting ready: how long that takes does not tell how long the frames will


def show_share(context: bpy.types.Context, verb: str, share: float) -> None:
    """Show in the status bar how far something is whose time is not known."""
    said = Message("{verb} {share:.0%} | Esc: cancel", verb=Message(verb), share=share)
    context.workspace.status_text_set(translated(said))


class FrameRange:
    """Give an operator a first and a last frame."""

    frame_start: IntProperty(
        name="First Frame", description="First frame of the animation. By default that of the scene", default=1
    )
    frame_end: IntProperty(
        name="Last Frame", description="Last frame of the animation. By default that of the scene", default=250
    )

    def _frames(self, scene: bpy.types.Scene) -> tuple[int, int]:
        given = self.properties.is_property_set
        return (
            self.frame_start if given("frame_start") else scene.frame_start,
            self.frame_end if given("frame_end") else scene.frame_end,
        )


class Working:
    """Give an operator its `execute`, `invoke`, `modal` and `cancel`.

    The operator brings:

    _begin(context): the steps, a generator of the share that is done; closing it undoes what is half done.
    _finished(context): what follows the last step.
    verb: what the status bar says it does.
    running: what the panel says meanwhile.
    stopped: the message after Esc.
    ready: the share after which the time left is known.
    """

    ready = 0.0
    _run = None  # while it asks for a file nothing runs yet

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Work in one go."""
        from ...core.base import DimpleError

        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            for share in self._begin(context):
                manager.progress_update(share)
            return self._finished(context)
        except DimpleError as error:
            return self._failed(str(error))
        finally:
            manager.progress_end()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Work with a progress bar, between Blender's own events."""
        from ...core.base import DimpleError

        try:
            self._steps = self._begin(context)
        except DimpleError as error:
            return self._failed(str(error))
        self._run = self._open(context)
        self._run.leave = self._leave
        self._began = time.perf_counter()
        context.window_manager.modal_handler_add(self)
        context.window_manager.progress_begin(0, 1)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Work a little; nothing else may change the scene meanwhile."""
        from ...core.base import DimpleError

        if self._run.closed:
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            sessions.disarm()
            modal_runs.close_run(self._run)
            say(self, {"INFO"}, self.stopped)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            with sessions.ending_on_error():
                share = self._work()
                if share < 1:
                    self._show(context, share)
                    return {"RUNNING_MODAL"}
                modal_runs.close_run(self._run)
                return self._finished(context)
        except DimpleError as error:
            return self._failed(str(error))

    def cancel(self, _context: bpy.types.Context) -> None:
        """Leave when Blender ends the operator: the window closes, another file is loaded."""
        if self._run is not None:
            modal_runs.close_run(self._run)

    def _open(self, context: bpy.types.Context) -> modal_runs.ModalRun:
        return modal_runs.open_run(context, "work", self.running, interval=0.01)

    def _done(self, sentence: str, messages: list[str]) -> set[str]:
        conclude(self, sentence, messages)
        return {"FINISHED"}

    def _work(self) -> float:
        """Work for a moment; return the share that is done, 1 when all is."""
        until = time.perf_counter() + SLICE_S
        while (share := next(self._steps, 1.0)) < 1 and time.perf_counter() < until:
            pass
        return share

    def _show(self, context: bpy.types.Context, share: float) -> None:
        context.window_manager.progress_update(share)
        if share <= self.ready:
            self._began = time.perf_counter()
            show_share(context, self.verb, share)
            return
        left = (time.perf_counter() - self._began) * (1 - share) / (share - self.ready)
        said = "{verb} {share:.0%}, {time} left | Esc: cancel"
        said = Message(said, verb=Message(self.verb), share=share, time=duration(left))
        context.workspace.status_text_set(translated(said))

    def _leave(self) -> None:
        self._steps.close()
        bpy.context.window_manager.progress_end()

    def _failed(self, why: str) -> set[str]:
        say(self, {"ERROR"}, why)
        return {"CANCELLED"}
