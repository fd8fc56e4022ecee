"""The sensory comparison of the paper's chapter 5: trials from a file, blind, each answer kept before the next."""

import time
from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

from ...core.errors import DimpleError
from ...core.messages import Message
from ..messages import report, say
from ..names import Op
from ..press import fingertip_objects, modal_runs, polls, sessions
from ..press.play import Driving
from . import blind_trial
from .blind_trial import FELT_S, HOLD_S, PRESS_S, RELEASE_S, experiments, trial


class DIMPLE_OT_open_experiment(polls.Declared, bpy.types.Operator):
    """Start or resume an experiment on the active object. Answers are saved beside its file"""

    bl_idname = Op.OPEN_EXPERIMENT
    bl_label = "Open Experiment"

    filepath: StringProperty(
        name="File", description="JSON or CSV file with the tasks of the experiment", subtype="FILE_PATH"
    )
    filter_glob: StringProperty(
        name="Filter", description="Files that are shown", options={"HIDDEN"}, default="*.json;*.csv"
    )
    participant: StringProperty(
        name="Participant", description="A number or code, not a name", default="1", maxlen=40
    )

    needs = polls.needs_mesh, polls.is_own, polls.is_free

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context: bpy.types.Context) -> None:
        from ...core.experiment.log import Log
        from ...core.experiment.plan import read_plan
        from ...core.experiment.run import Experiment

        path = Path(bpy.path.abspath(self.filepath))
        participant = self.participant.strip()
        if not participant:
            raise DimpleError("Give the participant a number or a code.")
        plan = read_plan(path)
        for task in plan.tasks:
            blind_trial.source_of(task.object)
        log = Log(blind_trial.log_path(path, participant))
        under_way = blind_trial.UnderWay(experiment=Experiment(plan, participant, log))
        blind_trial.close()
        under_way.obj = context.object.name, context.object.active_material
        experiments.append(under_way)
        done = len(under_way.experiment.log.rows)
        say(
            self, {"INFO"}, Message("{done} trials are answered", done=done) if done else "Read the consent, then begin"
        )


_is_open = polls.need(lambda _: experiments, "Open an experiment first")
_is_shown = polls.need(
    lambda _: (shown := trial()) and experiments[0].shown >= len(shown.shown),
    "Present the object first; in a comparison, both",
)


class DIMPLE_OT_agree_experiment(polls.Declared, bpy.types.Operator):
    """Confirm that the participant has read the text and agrees. Stopping is possible at any time"""

    bl_idname = Op.AGREE_EXPERIMENT
    bl_label = "I Agree, Begin"
    needs = (_is_open,)

    def run(self, _context: bpy.types.Context) -> None:
        experiments[0].agreed = True
        modal_runs.redraw()


class DIMPLE_OT_show_trial(Driving, bpy.types.Operator):
    """Present the object of this trial, to press with the device or to watch being pressed"""

    bl_idname = Op.SHOW_TRIAL
    bl_label = "Present"

    interval: IntProperty(name="Interval", description="1 is the first, 2 the second", default=1, min=1, max=2)

    needs = (
        _is_open,
        polls.need(lambda _: experiments[0].agreed, "Agree to the text first"),
        polls.need(lambda _: trial(), "All trials are answered"),
    )

    def run(self, context: bpy.types.Context) -> None:
        from ..bridge import timeline

        self._present(context)
        dt = timeline.frame_s(context.scene)
        with sessions.ending_on_error():
            for _ in range(round(self._length() / dt)):
                self._advance(context, dt, None)
        sessions.stop_all()

    def begin(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Present in real time: a replayed press to its end, an object to feel until the answer or Esc."""
        self._present(context)
        return self.drive(context, "play", "Trial: answer in the panel, Esc ends it")

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ..press import live_step

        over = self._seen and self._time > self._length()
        if over or (event.type == "ESC" and event.value == "PRESS") or not experiments:
            sessions.stop_all()
            return {"FINISHED"}
        if event.type == "TIMER":
            asked, budget = live_step.ask(context.scene, self._run, self.passed())
            self._advance(context, asked, budget)
            live_step.adapt(self._run, asked)
            modal_runs.redraw()
        return {"PASS_THROUGH"}

    def _length(self) -> float:
        return PRESS_S + HOLD_S + RELEASE_S if self._seen else FELT_S

    def _present(self, context: bpy.types.Context) -> None:
        """Give the object the stiffness of the interval and start its session."""
        from ..press import live_step, scripted_press

        under_way, shown = experiments[0], trial()
        sessions.stop_all()
        try:
            obj = context.view_layer.objects.get(under_way.obj[0])
            if obj is None:
                raise DimpleError("The object of the experiment is gone. Open the experiment again.")
            interval = min(self.interval, len(shown.shown))
            blind_trial.dress(obj, shown.task.object, shown.shown[interval - 1])
            fingertip_objects.select(context, obj)
            live_step.start_all(context)
            self._seen, self._time, self._state = shown.task.condition == "seen", 0.0, None
            if self._seen:
                press = blind_trial.seen_press(context)
                self._state = scripted_press.pressed(sessions.sessions, press, None, (0.0, 0.0, 0.0))
        except DimpleError:
            sessions.stop_all()
            raise
        if under_way.shown == 0:
            under_way.began, under_way.samples = time.perf_counter(), []
        under_way.shown = max(under_way.shown, interval)

    def _advance(self, context: bpy.types.Context, dt: float, budget: float | None) -> None:
        """Go on by a time [s]; note how deep and how hard the object is pressed."""
        from ...core.poke import Kind, PokeEvent, fingers, on_event
        from ..press import live_step

        pressed = None
        if self._seen:
            if self._time <= PRESS_S + HOLD_S < self._time + dt:
                self._state = on_event(self._state, PokeEvent(kind=Kind.RELEASE))
            self._state = on_event(self._state, PokeEvent(kind=Kind.TICK, amount=dt))
            pressed = {uid: fingers(self._state, uid) for uid in sessions.sessions}
        self._time += dt
        report(self, live_step.advance(context, dt, budget=budget, pressed=pressed))
        for body in sessions.sessions.values():
            frame = body.frame
            if len(frame.depths) and experiments:
                i = int(frame.depths.argmax())
                force = float(frame.pushes[i])
                experiments[0].samples.append((self._time, float(frame.depths[i]), force))


class DIMPLE_OT_answer_trial(polls.Declared, bpy.types.Operator):
    """Save this answer and go to the next trial"""

    bl_idname = Op.ANSWER_TRIAL
    bl_label = "Answer"

    choice: IntProperty(name="Choice", description="The step, or which of the two was stiffer", default=1, min=1, max=9)

    needs = _is_open, _is_shown

    def run(self, _context: bpy.types.Context) -> None:
        sessions.stop_all()
        under_way = experiments[0]
        seconds = time.perf_counter() - under_way.began
        under_way.experiment.answer(self.choice, seconds=seconds, samples=under_way.samples)
        under_way.shown, under_way.samples = 0, []
        modal_runs.redraw()


class DIMPLE_OT_stop_experiment(polls.Declared, bpy.types.Operator):
    """Stop the experiment. Opened again with the same participant, it resumes at this trial"""

    bl_idname = Op.STOP_EXPERIMENT
    bl_label = "Stop"
    needs = (_is_open,)

    def run(self, _context: bpy.types.Context) -> None:
        done = len(experiments[0].experiment.log.rows)
        blind_trial.close()
        say(self, {"INFO"}, Message("{done} trials are answered", done=done))


_register_classes, _unregister_classes = bpy.utils.register_classes_factory([
    DIMPLE_OT_open_experiment, DIMPLE_OT_agree_experiment, DIMPLE_OT_show_trial, DIMPLE_OT_answer_trial,
    DIMPLE_OT_stop_experiment,
])  # fmt: skip


@bpy.app.handlers.persistent
def _on_load_pre(*_: object) -> None:
    experiments.clear()


def register() -> None:
    _register_classes()
    bpy.app.handlers.load_pre.append(_on_load_pre)


def unregister() -> None:
    blind_trial.close()
    bpy.app.handlers.load_pre.remove(_on_load_pre)
    _unregister_classes()
