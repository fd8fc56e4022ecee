"""Shared parts of the panels: base classes, notes in boxes, and tables."""

from collections.abc import Callable

import bpy

from ..operators.experiment.blind_trial import is_blind
from ..operators.reporting import wrapped
from ..operators.translation import translated
from . import readout

CHARACTER = 6.5  # [px] upper bound on the mean width of a character in a note, at a resolution scale of 1
FRAME = 80.0  # [px] width of a note's icon and borders, at a resolution scale of 1


def shown_if(is_met: Callable[[bpy.types.Context], object]) -> classmethod:
    """Return the poll of a panel that is shown if a condition is met and no blind trial is under way."""
    return classmethod(lambda _cls, context: not is_blind() and bool(is_met(context)))


class SidebarPanel:
    """A panel in the sidebar of the 3D viewport."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Dimple"

    poll = shown_if(lambda _: True)


def draw_notes(
    context: bpy.types.Context, layout: bpy.types.UILayout, sentences: list[str], icon: str = "INFO"
) -> None:
    """Draw sentences in a box, translated and broken into lines that fit the region."""
    if not sentences:
        return
    column = layout.box().column(align=True)
    columns = max(12, int((context.region.width / context.preferences.system.ui_scale - FRAME) / CHARACTER))
    for sentence in sentences:
        for i, line in enumerate(wrapped(translated(sentence, readout.iface_), columns)):
            column.label(text=line, icon="BLANK1" if i else icon, translate=False)


def draw_prop(
    layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup, name: str, *, active: bool, slider: bool = False
) -> None:
    """Draw a setting, greyed out if it has no effect now."""
    row = layout.row()
    row.active = active
    row.prop(settings, name, slider=slider)


def draw_pins(layout: bpy.types.UILayout, body: bpy.types.Object) -> None:
    """Draw whether a part of a body is held, and by which vertex group: without one, its base."""
    row, settings = layout.row(heading="Pinned", align=True), body.dimple
    row.prop(settings, "pinned", text="" if settings.pin_group else "Base")
    row.prop_search(settings, "pin_group", body, "vertex_groups", text="")


def draw_rows(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    """Draw labels on the left and values on the right."""
    split = layout.split(factor=0.45)
    labels, values = split.column(align=True), split.column(align=True)
    for label, value in rows:
        labels.label(text=label, translate=False)
        values.label(text=value, translate=False)
