"""The panel on how a body is simulated: the planner's choice with its reason, other choices, and their comparison."""

from collections.abc import Sequence
from typing import Any

import bpy

from ..operators import calibration, compare_proxies
from ..operators.names import Op
from .comparison_chart import load, name_of
from .drawing import draw_notes


class DIMPLE_PT_reduction(bpy.types.Panel):
    """What is simulated in place of the mesh, and why."""

    bl_label = "Speed and Accuracy"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"
    bl_parent_id = "DIMPLE_PT_body"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Show on meshes."""
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the choice, the tolerances, the reason and the comparison."""
        body, layout = context.object, self.layout
        layout.use_property_split = True
        layout.enabled = body.dimple.enabled
        settings = body.dimple
        layout.prop(settings, "simulated")
        row = layout.row()
        row.active = settings.simulated == "PROXY"
        row.prop(settings, "proxy_vertices")
        column = layout.column(align=True)
        column.active = settings.simulated == "AUTO"
        column.prop(settings, "tolerance_mm")
        column.prop(settings, "tolerance_percent")
        column.prop(context.scene.dimple, "frame_budget_percent")
        if settings.plan_reason:
            draw_notes(context, layout, [settings.plan_reason])
        layout.operator(Op.COMPARE_PROXIES, icon="SORTSIZE")
        variants = load(settings)
        if variants:
            layout.prop(context.window_manager.dimple, "show_comparison")
            kept = calibration.load(settings.comparison).get("depends_on")
            if kept != compare_proxies.depends_on(context.scene, body):
                draw_notes(context, layout, ["The body or the fingertip has changed: compare again"])
            draw_table(layout, variants)


def draw_table(layout: bpy.types.UILayout, variants: Sequence[dict[str, Any]]) -> None:
    """List every variant that was compared, each with a button that chooses it."""
    for variant in variants:
        row = layout.row(align=True)
        for number in numbers(variant):
            row.label(text=number, translate=False)
        row.operator(Op.APPLY_PROXY, text="", icon="CHECKMARK").vertices = variant["asked"]


def numbers(variant: dict[str, Any]) -> tuple[str, ...]:
    """Return a row of the table: name, processor time [s] per second, errors of the surface and of the force."""
    return (
        name_of(variant),
        f"{variant['cost']:.2g} s/s",
        f"{variant['error']:.2g} mm",
        f"{variant['force_error']:.0%}",
    )


register, unregister = bpy.utils.register_classes_factory([DIMPLE_PT_reduction])
