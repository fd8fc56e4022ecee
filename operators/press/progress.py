"""Tasks of more than a second: run in one go from a script, else between Blender's events with the time left shown.

Large meshes are prepared in this way before they are poked or played.
"""

import time
from operator import attrgetter

import bpy
from bpy.props import IntProperty, StringProperty

from ...core.message import Message
from ..names import Op
from ..reporting import Note, duration, report, say
from ..translation import translated
from . import modal_runs, polls, sessions

SLICE_S = 0.1  # [s] work between two checks of the keyboard
LARGE = 20_000  # total number of vertices above which reading takes longer than a second
READY = 0.05  # fraction of a bake for preparation, whose duration says nothing about that of the frames


class FrameRange:
    """Give an operator a first and a last frame."""

    frame_start: IntProperty(
        name="First Frame", description="First frame of the animation; by default, that of the scene", default=1
    )
    frame_end: IntProperty(
        name="Last Frame", description="Last frame of the animation; by default, that of the scene", default=250
    )

    def _frames(self, scene: bpy.types.Scene) -> tuple[int, int]:
        given = self.properties.is_property_set
        return (
            self.frame_start if given("frame_start") else scene.frame_start,
            self.frame_end if given("frame_end") else scene.frame_end,
        )


class Working(polls.Declared):
    """Give an operator its `run`, `invoke`, `modal` and `cancel`.

    The operator defines:

    _begin(context): return a generator that works in steps and yields the fraction done; closing it undoes them.
    _finished(context): act after the last step, and return the operator's result.
    verb: the activity, as the status bar names it.
    stopped: message after Esc.
    ready: fraction done after which the remaining time can be estimated.
    asked: names of the properties that a file browser asks for, if it sets `browsing`.
    """

    ready, asked, browsing = 0.0, (), False
    _run = None  # still None while the operator asks for a file

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do all the work in one go; after a file browser start a new call, because this one cannot become modal."""
        if self.browsing:
            settings = {name: getattr(self, name) for name in self.asked if self.properties.is_property_set(name)}
            attrgetter(type(self).bl_idname)(bpy.ops)("INVOKE_DEFAULT", **settings)
            return {"CANCELLED"}
        return super().execute(context)

    def run(self, context: bpy.types.Context) -> set[str]:
        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            for share in self._begin(context):
                manager.progress_update(share)
            return self._finished(context)
        finally:
            manager.progress_end()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Work between Blender's own events, with a progress bar."""
        return self.trying(self._start, context)

    def _start(self, context: bpy.types.Context) -> set[str]:
        self._steps = self._begin(context)
        self._run = modal_runs.open_run(context, "work", interval=0.01)
        self._run.leave = self._leave
        context.window_manager.modal_handler_add(self)
        context.window_manager.progress_begin(0, 1)
        self._show(context, 0.0)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Work for a moment at each timer event; block all other events, so that nothing changes the scene."""
        if self._run.closed:
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            sessions.disarm()
            modal_runs.close_run(self._run)
            say(self, {"INFO"}, self.stopped)
            return {"CANCELLED"}
        return self.trying(self._go_on, context) if event.type == "TIMER" else {"RUNNING_MODAL"}

    def _go_on(self, context: bpy.types.Context) -> set[str]:
        with sessions.ending_on_error():
            share = self._work()
            if share < 1:
                self._show(context, share)
                return {"RUNNING_MODAL"}
            modal_runs.close_run(self._run)
            return self._finished(context)

    def cancel(self, _context: bpy.types.Context) -> None:
        """Stop the task when Blender cancels the operator: its window closes, or another file is loaded."""
        if self._run is not None:
            modal_runs.close_run(self._run)

    def _done(self, sentence: str, messages: list[str]) -> set[str]:
        """Report notes, then what was done, then warnings, because Blender shows the last report."""
        report(self, sorted([*messages, Note(sentence)], key=lambda each: not isinstance(each, Note)))
        return {"FINISHED"}

    def _work(self) -> float:
        """Work for a moment; return the fraction done, 1 at the end."""
        until = time.perf_counter() + SLICE_S
        while (share := next(self._steps, 1.0)) < 1 and time.perf_counter() < until:
            pass
        return share

    def _show(self, context: bpy.types.Context, share: float) -> None:
        context.window_manager.progress_update(share)
        verb = Message(self.verb)
        if share <= self.ready:
            self._began = time.perf_counter()
            said = Message("{verb} {share:.0%} | Esc: cancel", verb=verb, share=share)
        else:
            left = duration((time.perf_counter() - self._began) * (1 - share) / (share - self.ready))
            said = Message("{verb} {share:.0%}, {time} left | Esc: cancel", verb=verb, share=share, time=left)
        context.workspace.status_text_set(translated(said))

    def _leave(self) -> None:
        self._steps.close()
        bpy.context.window_manager.progress_end()


class DIMPLE_OT_start(Working, bpy.types.Operator):
    """Prepare the selected meshes, then start Poke or Play"""

    bl_idname = Op.START
    bl_label = "Get Ready"
    bl_options = {"INTERNAL"}
    verb, stopped = "Getting ready", "Nothing was started"
    ready = 1.0  # the remaining time is never known

    then: StringProperty(name="Then", description="The operator that follows", options={"HIDDEN", "SKIP_SAVE"})

    def _begin(self, context: bpy.types.Context):
        from ...core.background_work import beside
        from . import live_step

        self._came = yield from beside(live_step.starting_all(context), SLICE_S)

    def _finished(self, _context: bpy.types.Context) -> set[str]:
        _, messages, wrong = self._came
        report(self, [*wrong, *messages])
        attrgetter(self.then)(bpy.ops)("INVOKE_DEFAULT")
        return {"FINISHED"}


def takes_long(context: bpy.types.Context) -> bool:
    """Return whether the meshes whose sessions would be started are large.

    Raises:
        DimpleError: nothing can be started.
    """
    from . import live_step

    graph = context.evaluated_depsgraph_get()
    waiting = [obj for obj in live_step.candidates(context) if obj.type == "MESH" and sessions.get(obj) is None]
    return sum(len(obj.evaluated_get(graph).data.vertices) for obj in waiting) > LARGE
