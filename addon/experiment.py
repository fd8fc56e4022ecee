"""The sensory comparison in the sidebar: the consent, the trial, and the answers."""

import bpy

from ..core.message import Message
from ..operators.experiment.blind_trial import experiments
from ..operators.names import Op
from .panel_parts import SidebarPanel, draw_notes
from .readout import iface_


class DIMPLE_PT_experiment(SidebarPanel, bpy.types.Panel):
    """Compare the virtual object with the real one, or with itself at another stiffness."""

    bl_label = "Sensory Comparison"
    bl_options = {"DEFAULT_CLOSED"}

    poll = classmethod(lambda _cls, _context: True)  # also shown in a blind trial

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the next step, without revealing the stimuli."""
        layout = self.layout
        if not experiments:
            layout.operator(Op.OPEN_EXPERIMENT, icon="FILE_FOLDER")
            return
        experiment, left = experiments[0], experiments[0].left()
        plan, trial = experiment.plan, experiment.trial
        if not experiment.agreed:
            minutes = sum(plan.trial_s + each.rest_s for each in left) / 60
            draw_notes(context, layout, [
                experiment.participant, plan.consent,
                Message("{count} trials, about {minutes:.0f} minutes", count=len(left), minutes=minutes),
            ])  # fmt: skip
            layout.operator(Op.CONTINUE_EXPERIMENT, text="I Agree, Begin", icon="CHECKMARK")
        elif trial is None:
            draw_notes(context, layout, ["All trials are answered. Thank you."], "CHECKMARK")
        else:
            of = iface_("Trial {} of {}").format(trial.number, len(experiment.trials))
            layout.label(text=of, translate=False)
            if experiment.rests:
                draw_notes(context, layout, ["Rest until the next object can be presented."])
            for label in {each.real for each in trial.show if each.real and not experiment.intervals}:
                draw_notes(context, layout, [Message("Experimenter: present object {label}.", label=label)])
            draw_notes(context, layout, [plan.instruction])
            for number, stimulus in enumerate(trial.show):
                row = layout.row()
                row.enabled = number == experiment.due
                what = iface_("Touch the real object") if stimulus.real else iface_("Touch the virtual object")
                row.operator(Op.CONTINUE_EXPERIMENT, text=what, translate=False)
            draw_notes(context, layout, [plan.question])
            column = layout.column(align=True)
            for choice, words in enumerate(plan.answers, start=1):
                column.operator(Op.ANSWER_TRIAL, text=words, translate=False).choice = choice
        layout.operator(Op.STOP_EXPERIMENT, icon="CANCEL")


SIDEBAR = (DIMPLE_PT_experiment,)
