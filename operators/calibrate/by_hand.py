"""Calibrate with a kitchen scale: a table in the scene, typed or pasted, and the fit of the law."""

import bpy

from ...core.errors import DimpleError
from ..names import Op
from ..press import polls
from .from_file import WIDTH, Tip


class DIMPLE_OT_paste_table(polls.Declared, bpy.types.Operator):
    """Fill the table from the clipboard: two columns, steps and grams"""

    bl_idname = Op.PASTE_TABLE
    bl_label = "Paste"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context: bpy.types.Context) -> None:
        from ...core.calibration.reader import pairs

        table, rows = context.scene.dimple, pairs(context.window_manager.clipboard)
        most = len(table.hand_depths)
        if len(rows) > most:
            raise DimpleError("The table holds {most} rows at most. Save longer ones as CSV, and open that.", most=most)
        depths, grams = zip(*rows, strict=True)
        empty = range(1, most - len(rows) + 1)  # the remaining rows, each a step deeper
        table.hand_depths = [*depths, *(depths[-1] + step for step in empty)]
        table.hand_grams = [*grams, *(0.0 for _ in empty)]


class DIMPLE_OT_calibrate_by_hand(Tip, polls.Declared, bpy.types.Operator):
    """Fit a material to the table of depths and grams"""

    bl_idname = Op.CALIBRATE_BY_HAND
    bl_label = "Fit Table"
    bl_options = {"REGISTER", "UNDO"}

    needs = (polls.in_object_mode,)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Ask what pressed the object."""
        self.take_size(context)
        return context.window_manager.invoke_props_dialog(self, width=WIDTH // 2)

    def run(self, context: bpy.types.Context) -> None:
        from ...core.calibration.calibrate import calibrate_by_hand

        table = context.scene.dimple
        pairs = zip(table.hand_depths, table.hand_grams, strict=True)
        rows = [(steps * table.hand_step_mm, grams) for steps, grams in pairs if grams]
        rows += [] if any(depth == 0 for depth, _ in rows) else [(0.0, 0.0)]
        self.keep(context, calibrate_by_hand(*zip(*rows, strict=True), **self.measured()))
