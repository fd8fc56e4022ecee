"""Let time run without the timeline: fingertip objects press, bodies swing, fall and come to rest."""

import time

import bpy
from bpy.props import FloatProperty

from . import polls, sessions, showing
from .messages import report
from .names import Op


class DIMPLE_OT_play(bpy.types.Operator):
    """Run or pause the selected bodies without the timeline; fingertip objects press them. Esc ends and restores"""

    bl_idname = Op.PLAY
    bl_label = "Play"

    seconds: FloatProperty(
        name="Seconds", description="From a script: how long to run", default=1.0, min=0.0, soft_max=60.0
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need Object Mode and no bake."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode to play")
        return polls.is_free(cls)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Run for some seconds at once, frame by frame of the scene."""
        from ..core.base import DimpleError
        from . import live

        try:
            polls.check_numbers(self, "seconds")
            self._report(live.start_all(context))
        except DimpleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        render = context.scene.render
        frames = max(round(self.seconds * render.fps / render.fps_base), 1)
        with sessions.ending_on_error():
            for _ in range(frames):
                report(self, live.advance(context, self.seconds / frames))
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Start, pause or go on."""
        from ..core.base import DimpleError
        from . import live

        if sessions.runs:
            run = sessions.runs[0]
            sessions.pause(context, run, not run.paused)
            return {"FINISHED"}
        try:
            self._report(live.start_all(context))
        except DimpleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._run = sessions.open_run(context, "play", "Playing: Esc ends and puts the rest shape back")
        self._clock = time.perf_counter()
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Step by the clock; everything but Esc is Blender's."""
        if self._run.closed:
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            report(self, sessions.stop_all())
            return {"CANCELLED"}
        if event.type == "TIMER":
            with sessions.ending_on_error():
                return self._tick(context)
        return {"PASS_THROUGH"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """End when Blender ends the operator: the window closes, another file is loaded."""
        if not self._run.closed:
            sessions.stop_all()

    def _tick(self, context: bpy.types.Context) -> set[str]:
        from . import live, recovery

        now = time.perf_counter()
        wall, self._clock = now - self._clock, now
        if self._run.paused:
            messages = showing.end_changed(context.view_layer)
        else:
            asked, budget = live.ask(context.scene, self._run, wall)
            messages = live.advance(context, asked, budget=budget)
            live.adapt(self._run, asked)
        report(self, [*messages, *recovery.save_when_due(self._run)])
        sessions.redraw()
        if not sessions.sessions:
            sessions.stop_all()
            return {"CANCELLED"}
        return {"PASS_THROUGH"}

    def _report(self, started: tuple[list, list[str], list[str]]) -> None:
        _, messages, wrong = started
        report(self, wrong)
        if messages:
            self.report({"INFO"}, " ".join(messages))


class DIMPLE_OT_reset(bpy.types.Operator):
    """End every session and put the rest shapes back exactly"""

    bl_idname = Op.RESET
    bl_label = "Reset"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Need something that runs."""
        if not (sessions.sessions or sessions.runs):
            return polls.refuse(cls, "Nothing is being pressed")
        return True

    def execute(self, _context: bpy.types.Context) -> set[str]:
        """Put everything back."""
        report(self, sessions.stop_all())
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_play, DIMPLE_OT_reset])
