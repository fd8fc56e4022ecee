"""The sensory comparison of the paper's chapter 5: blind trials from a file, each answer saved before the next trial.

The stimulus of a trial is stored nowhere in Blender's data, so no panel, name or undo step reveals it.
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import IntProperty, StringProperty

from ...core.errors import DimpleError
from ...core.message import Message
from ..bridge import in_trial
from ..calibrate.from_file import Opened, shown_files
from ..device.connect_device import is_ready
from ..names import Op
from ..press import fingertip_objects, haptic_fingertips, modal_runs, polls, sessions
from ..reporting import say

if TYPE_CHECKING:
    from ...core.experiment.plan_file import Plan
    from ...core.experiment.run import Experiment
    from ...core.material import Material

HELD_S = 60.0  # [s] for which a script holds the dead-man key

experiments: "list[Experiment]" = []  # the current experiment, if there is one


def is_blind() -> bool:
    """Return whether a participant is judging: then no number and no chart may show the stiffness of the object."""
    return bool(experiments) and experiments[0].agreed


@bpy.app.handlers.persistent
def close(*_: object) -> None:
    """End the current experiment; its answers are kept."""
    while experiments:
        sessions.stop_all()
        experiments.pop().log.file.close()
    in_trial.clear()


def watch(connection: haptic_fingertips.Connection) -> None:
    """Record what the device does in the current interval."""
    if experiments and experiments[0].intervals:
        experiments[0].intervals[-1].feel(connection.device.samples(), connection.report.cap)


def material_of(source: str) -> "Material":
    """Return the constants of the preset or the Blender material that a plan names.

    Raises:
        DimpleError: there is none.
    """
    from ...core.everyday_presets import OBJECTS
    from ...core.material import Material

    preset = next((each.material for each in OBJECTS if source in (each.name, each.label)), None)
    material = bpy.data.materials.get(source)
    if preset is None and material is None:
        raise DimpleError('There is no material or preset "{name}", which the experiment names.', name=source)
    return preset or Material(**material.dimple.to_params())


def at_level(material: "Material", level: float) -> "Material":
    """Return a material with its stiffness scaled."""
    return replace(material, K1=level * material.K1, K2=level * material.K2)


def needed_cap(scene: bpy.types.Scene, material: "Material", force: float) -> float:
    """Return the stiffness [N/m] that a device must be able to render for an unchanged material up to a force [N]."""
    from ...core.device.rendered_surface import Law
    from ...core.other_tip import BODY, factors

    scale = scene.dimple.device_scale
    table = factors([material], scene.dimple.finger_radius_mm / 1e3, BODY)
    values, deepest = (tuple(table[0][0].tolist()), table[1]) if table else ((), 0.0)
    x0, power = material.x0 / scale, material.power
    return Law(material.K1, material.K2, x0, power, values, deepest / scale).steepest(force)


def check_levels(scene: bpy.types.Scene, plan: "Plan", materials: dict[str, "Material"]) -> None:
    """Raise a DimpleError if the device cannot render what the plan presents."""
    cap = haptic_fingertips.get().report.cap
    for label, level in sorted(plan.stimuli()):
        needed = needed_cap(scene, at_level(materials[label], level), plan.press_n)
        if needed > cap:
            raise DimpleError(
                "The device renders up to {cap:.2f} N/mm now. Object {label} at the level {level:g} needs "
                "{needed:.2f} N/mm up to {force:g} N.",
                cap=cap / 1e3, label=label, level=level, needed=needed / 1e3, force=plan.press_n
            )  # fmt: skip


class DIMPLE_OT_open_experiment(Opened, polls.Declared, bpy.types.Operator):
    """Start or resume an experiment on the active object. Answers are saved beside its file"""

    bl_idname = Op.OPEN_EXPERIMENT
    bl_label = "Open Experiment"

    filter_glob: shown_files("*.json")
    participant: StringProperty(name="Participant", description="Participant code from the file", options={"SKIP_SAVE"})

    needs = polls.needs_mesh, polls.is_own, polls.is_free, is_ready

    def run(self, context: bpy.types.Context) -> None:
        from ...core.experiment.plan_file import read_plan
        from ...core.experiment.run import Experiment
        from ..bridge.bake_files import version

        path, settings = Path(bpy.path.abspath(self.filepath)), context.scene.dimple
        plan, participant = read_plan(path), self.participant.strip()
        if participant not in plan.participants:
            raise DimpleError("Type the participant's code, one of {codes}.", codes=tuple(plan.participants))
        materials = {label: material_of(source) for label, source in plan.objects.items()}
        check_levels(context.scene, plan, materials)
        connection = haptic_fingertips.get()
        stated = {
            "dimple": version(), "blender": bpy.app.version_string, "object": context.object.name,
            "fingertip_mm": settings.finger_radius_mm, "port": connection.device.port, "scale": settings.device_scale,
            "cap_n_m": connection.report.cap, "peak_n": connection.report.peak,
        }  # fmt: skip
        close()
        answers = path.with_name(f"{path.stem}_{participant}.csv")
        experiments.append(Experiment(plan, participant, answers, materials, stated))
        say(self, {"INFO"}, Message("{left} trials are left", left=len(experiments[0].left())))


_is_open = polls.need(lambda _: experiments, "Open an experiment first")


class DIMPLE_OT_continue_experiment(polls.Declared, bpy.types.Operator):
    """Agree to the text and begin; later, present the next object of the trial. You can stop at any time"""

    bl_idname = Op.CONTINUE_EXPERIMENT
    bl_label = "Continue"
    needs = (
        _is_open, is_ready, polls.need(lambda _: not experiments[0].rests, "Rest a little longer"),
        polls.need(lambda _: not experiments[0].agreed or not experiments[0].is_shown, "All objects were presented"),
    )  # fmt: skip

    def run(self, context: bpy.types.Context) -> None:
        sessions.stop_all()
        if experiments[0].agreed:
            self._present(context, experiments[0])
        else:
            experiments[0].agree()
        modal_runs.redraw()

    def _present(self, context: bpy.types.Context, experiment: "Experiment") -> None:
        """Begin the next interval: for a virtual object, with a session of its constants and an armed device."""
        from ...core.device.limits import QUIET_FORCE
        from ..press import live_step

        haptic_fingertips.get().device.samples()  # discard those from before this interval
        stimulus = experiment.trial.show[experiment.due]
        if stimulus.real:
            experiment.begin()
            return
        obj = context.view_layer.objects.get(experiment.stated["object"])
        if obj is None:
            raise DimpleError("The object of the experiment is gone. Open the experiment again.")
        material, force = at_level(experiment.materials[stimulus.object], stimulus.level), experiment.plan.press_n
        in_trial[obj.session_uid] = material
        fingertip_objects.select(context, obj)
        live_step.start_all(context)
        experiment.begin(needed=needed_cap(context.scene, material, force), least_n=QUIET_FORCE, most_n=force)
        how = "INVOKE_DEFAULT" if self.options.is_invoke else "EXEC_DEFAULT"
        bpy.ops.dimple.play(how, seconds=0.0)
        bpy.ops.dimple.arm_device(how, hold_s=HELD_S)


class DIMPLE_OT_answer_trial(polls.Declared, bpy.types.Operator):
    """Save this answer and go to the next trial"""

    bl_idname = Op.ANSWER_TRIAL
    bl_label = "Answer"

    choice: IntProperty(name="Choice", description="Number of the answer", default=1, min=1)

    needs = _is_open, polls.need(lambda _: experiments[0].is_shown, "Touch each object for long enough first")

    def run(self, _context: bpy.types.Context) -> None:
        sessions.stop_all()
        experiments[0].answer(self.choice)
        modal_runs.redraw()


class DIMPLE_OT_stop_experiment(polls.Declared, bpy.types.Operator):
    """Stop the experiment. Opened again with the same participant, it resumes at this trial"""

    bl_idname = Op.STOP_EXPERIMENT
    bl_label = "Stop"
    needs = (_is_open,)

    def run(self, _context: bpy.types.Context) -> None:
        say(self, {"INFO"}, Message("{left} trials are left", left=len(experiments[0].left())))
        close()


_register_classes, _unregister_classes = bpy.utils.register_classes_factory([
    DIMPLE_OT_open_experiment, DIMPLE_OT_continue_experiment, DIMPLE_OT_answer_trial, DIMPLE_OT_stop_experiment,
])  # fmt: skip


def register() -> None:
    _register_classes()
    bpy.app.handlers.load_pre.append(close)
    haptic_fingertips.watching.append(watch)


def unregister() -> None:
    close()
    haptic_fingertips.watching.remove(watch)
    bpy.app.handlers.load_pre.remove(close)
    _unregister_classes()
