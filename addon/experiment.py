"""The sensory comparison in the sidebar: the text to agree to, the trial under its blind label, and the answers."""

import bpy

from ..operators.experiment import blind_trial
from ..operators.names import Op
from .drawing import SidebarPanel, draw_notes
from .readout import iface_


class DIMPLE_PT_experiment(SidebarPanel, bpy.types.Panel):
    """Compare the virtual object with the real one, or with itself at another stiffness."""

    bl_label = "Sensory Comparison"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the next step, without a hint at which object it is."""
        layout, under_way = self.layout, blind_trial.get()
        if under_way is None:
            layout.operator(Op.OPEN_EXPERIMENT, icon="FILE_FOLDER")
            return
        if not under_way.agreed:
            draw_notes(context, layout, [under_way.experiment.plan.consent])
            layout.operator(Op.AGREE_EXPERIMENT, icon="CHECKMARK")
        else:
            draw_trial(context, layout, under_way)
        layout.operator(Op.STOP_EXPERIMENT, icon="CANCEL")


def draw_trial(context: bpy.types.Context, layout: bpy.types.UILayout, under_way: object) -> None:
    """Draw the trial that is next."""
    trial = blind_trial.trial()
    if trial is None:
        draw_notes(context, layout, ["All trials are answered. Thank you."], "CHECKMARK")
        return
    label = iface_("Trial {} of {}, Object {}").format(trial.number, trial.of, trial.label)
    layout.label(text=label, translate=False)
    ordinals = iface_("First"), iface_("Second")
    row = layout.row(align=True)
    for interval in range(1, len(trial.shown) + 1):
        name = iface_("Present") if len(trial.shown) == 1 else ordinals[interval - 1]
        button = row.operator(Op.SHOW_TRIAL, text=name, translate=False, icon="HIDE_OFF")
        button.interval = interval
    rating = trial.task.kind == "rating"
    layout.label(text="How like the real object is it?" if rating else "Which was stiffer?")
    column = layout.column(align=True)
    for choice, words in enumerate(map(iface_, trial.task.steps) if rating else ordinals, start=1):
        button = column.operator(Op.ANSWER_TRIAL, text=words, translate=False)
        button.choice = choice


SIDEBAR = (DIMPLE_PT_experiment,)
