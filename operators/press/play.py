"""Play: run the simulation in real time, or along the timeline while Blender plays it."""

import time

import bpy
from bpy.props import FloatProperty, IntProperty

from ..names import Op
from ..reporting import gathered, report, say
from . import modal_runs, polls, progress, sessions, showing

PLAYING = "Playing: Esc ends and restores the rest shape"
PAUSED = "Paused: Play continues, Esc ends and restores the rest shape"


class Driving(polls.Declared):
    """Base of an operator that also drives the sessions live: `begin` starts it, and `handle` handles each event."""

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return self.trying(self.begin, context, event)

    def starts_later(self, context: bpy.types.Context) -> bool:
        """Return whether large meshes must be prepared first; if so, start that, which calls this operator again."""
        later = progress.takes_long(context)
        if later:
            bpy.ops.dimple.start("INVOKE_DEFAULT", then=type(self).bl_idname)
        return later

    def start(self, context: bpy.types.Context) -> None:
        """Start a session on each selected mesh, and report the messages."""
        from . import live_step

        _, messages, wrong = live_step.start_all(context)
        report(self, wrong)
        if messages:
            say(self, {"INFO"}, *gathered(messages))

    def drive(self, context: bpy.types.Context, kind: str) -> set[str]:
        """Start a timer and handle all events from now on; see `modal_runs.open_run`."""
        self._run, self._clock = modal_runs.open_run(context, kind), time.perf_counter()
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Handle an event; on an error end all sessions and restore all shapes."""
        if self._run.closed:
            return {"CANCELLED"}
        with sessions.ending_on_error():
            return self.handle(context, event)

    def passed(self) -> float:
        """Return the wall time since the last call [s]."""
        before, self._clock = self._clock, time.perf_counter()
        return self._clock - before

    def went_on(self, messages: list[str]) -> set[str] | None:
        """Report messages; return the result that ends the operator if no session is left, else None."""
        report(self, messages)
        if sessions.sessions:
            return None
        sessions.stop_all()
        return {"CANCELLED"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """End the sessions when Blender cancels the operator: its window closes, or another file is loaded."""
        if not self._run.closed:
            sessions.stop_all()


class DIMPLE_OT_play(Driving, bpy.types.Operator):
    """Play or pause the selected bodies, which fingertip objects press. Esc ends it and restores the shapes"""

    bl_idname = Op.PLAY
    bl_label = "Play"

    seconds: FloatProperty(
        name="Seconds", description="For scripts: how long to run", default=1.0, min=0.0, soft_max=60.0
    )
    frames: IntProperty(
        name="Frames",
        description="For scripts: number of frames of the timeline to run, as in a bake, instead of seconds",
        default=0,
        min=0,
    )

    needs = polls.in_object_mode, polls.is_free

    def run(self, context: bpy.types.Context) -> None:
        from ..bridge import timeline
        from . import live_step

        polls.check_numbers(self, "seconds")
        self.start(context)
        scene = context.scene
        now, count = scene.frame_current, max(round(self.seconds / timeline.frame_s(scene)), 1)
        with sessions.ending_on_error():
            for _ in range(0 if self.frames else count):
                report(self, live_step.advance(context, self.seconds / count))
            if self.frames and _at_rest():  # a fingertip's path begins at its current place
                report(self, live_step.advance(context, 0.0))
            for frame in range(now, now + self.frames):
                report(self, live_step.advance_to(context, frame + 1))

    def begin(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Start, pause or continue."""
        if modal_runs.runs:
            run = modal_runs.runs[0]
            run.paused = not run.paused
            return {"FINISHED"}
        if self.starts_later(context):
            return {"CANCELLED"}
        self.start(context)
        self._frame = context.scene.frame_current
        return self.drive(context, "play")

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Step by the clock, or along the timeline while it plays; pass all events but Esc on to Blender."""
        if event.type == "ESC" and event.value == "PRESS":
            sessions.stop_all()
            return {"CANCELLED"}
        return self._tick(context) if event.type == "TIMER" else {"PASS_THROUGH"}

    def _tick(self, context: bpy.types.Context) -> set[str]:
        from ..bridge import timeline
        from . import live_step

        wall = self.passed()
        modal_runs.show_status(context, self._run, polls.tip_(PAUSED if self._run.paused else PLAYING))
        playing = timeline.is_playing(context)
        modal_runs.follow_timeline(context, self._run, playing)
        if self._run.paused:
            messages = showing.end_changed(context.view_layer)
        elif playing:
            messages = self._follow(context)
        else:
            asked, budget = live_step.ask(context.scene, self._run, wall)
            messages = live_step.advance(context, asked, budget=budget)
            live_step.adapt(self._run, asked)
        modal_runs.redraw()
        return self.went_on([*messages, *modal_runs.save_when_due(self._run)]) or {"PASS_THROUGH"}

    def _follow(self, context: bpy.types.Context) -> list[str]:
        """Advance by one frame of the timeline, as a bake does; if the timeline was rewound, start again at rest."""
        from . import live_step, props

        scene, before = context.scene, self._frame
        if scene.frame_current > before:
            self._frame += 1
            return live_step.advance_to(context, self._frame)
        self._frame = scene.frame_current
        if self._frame == before and not _at_rest():
            return showing.end_changed(context.view_layer)
        for body in sessions.sessions.values():
            body.session.reset()
            sessions.set_worlds(())
            props.put_back()
            body.matrix, body.rest = body.link.matrix, body.link.rest
        return live_step.advance(context, 0.0)


def _at_rest() -> bool:
    """Return whether no session has been stepped yet."""
    return not any(body.frame.time for body in sessions.sessions.values())


class DIMPLE_OT_reset(polls.Declared, bpy.types.Operator):
    """Stop pressing, and put every shape back exactly as it was"""

    bl_idname = Op.RESET
    bl_label = "Reset"

    needs = (polls.need(lambda _: sessions.sessions or modal_runs.runs, "Nothing is being pressed"),)

    def run(self, _context: bpy.types.Context) -> None:
        sessions.stop_all()
