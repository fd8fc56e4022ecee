"""The sidebar tab, with its panels in the order of work.

Controls that cannot be used now are greyed out, not hidden; the operator's poll gives the reason in the tooltip.
"""

import bpy

from ..operators.bridge import sizing
from ..operators.names import Op
from ..operators.press.fingertip_objects import body_of
from ..operators.press.sessions import sessions
from ..operators.reporting import Note
from . import calibration, device, experiment, materials, physics_panels, readout
from .panel_parts import SidebarPanel, draw_notes, draw_rows


class DIMPLE_PT_session(SidebarPanel, bpy.types.Panel):
    """The operators of a press."""

    bl_label = "Press"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout, body = context.scene.dimple, self.layout, body_of(context.object, context.scene)
        entry = sessions.get(body.session_uid) if body else None
        column = layout.column(align=True)
        column.scale_y = 1.4
        row = column.row(align=True)
        row.enabled = body is not None and not (body.type == "MESH" and body.dimple.enabled)
        row.operator(Op.MAKE_SOFT, icon="MOD_SOFT")
        column.operator(Op.POKE, icon="RESTRICT_SELECT_OFF")
        row = layout.row(align=True)
        running = entry is not None and entry.running
        row.operator(Op.PLAY, text="Pause" if running else "Play", icon="PAUSE" if running else "PLAY")
        row.operator(Op.RESET, icon="LOOP_BACK")
        row = layout.row()
        row.prop(settings, "use_gravity")
        row.prop(settings, "use_ground")
        draw_notes(context, layout, readout.warnings(entry) if entry else [], "ERROR")
        if body is None or body.type != "MESH":
            draw_notes(context, layout, ["Select a mesh to press it."])


class DIMPLE_PT_readout(SidebarPanel, bpy.types.Panel):
    """The numbers of the session."""

    bl_label = "Numbers"
    bl_parent_id = "DIMPLE_PT_session"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, body = self.layout, body_of(context.object, context.scene)
        entry = sessions.get(body.session_uid) if body else None
        if entry is None:
            layout.label(text="Nothing is being pressed")
            return
        draw_rows(layout, readout.rows(entry.frame) + readout.more_rows(entry.frame, entry.session.clock.tick))
        draw_notes(context, layout, [note for note in entry.session.model.notes if isinstance(note, Note)])


class DIMPLE_PT_fingertips(SidebarPanel, bpy.types.Panel):
    """The fingertips of the scene; the header of the tool has their radius and depth."""

    bl_label = "Fingertips"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.dimple, self.layout
        layout.use_property_split = True
        layout.prop(settings, "active_finger")
        column = layout.column(align=True)
        for number in sizing.NUMBERS:
            column.prop(settings, f"finger_{number}")
        if any(tip and tip.type != "EMPTY" for tip in sizing.fingertips(context.scene)):
            draw_notes(context, layout, ["A fingertip presses like a ball of the tool's radius, whatever its shape."])
        column = layout.column(align=True)
        column.operator(Op.ADD_FINGERTIP, icon="SPHERE")
        column.operator(Op.KEY_PRESS, icon="REC")


class DIMPLE_PT_animate(SidebarPanel, bpy.types.Panel):
    """Bake a press to an animation, and export it."""

    bl_label = "Animate"

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene = self.layout, context.scene
        column = layout.column(align=True)
        column.scale_y = 1.4
        button = column.operator(Op.BAKE, icon="RENDER_ANIMATION")
        button.frame_start, button.frame_end = scene.frame_start, scene.frame_end
        column.operator(Op.EXPORT, icon="EXPORT")
        layout.operator(Op.UNBAKE, icon="TRASH")
        layout.use_property_split = True
        layout.prop(scene.dimple, "cache_dir")


class DIMPLE_PT_display(SidebarPanel, bpy.types.Panel):
    """The switches of the overlay."""

    bl_label = "Display"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.dimple, self.layout
        layout.use_property_split = True
        layout.prop(settings, "show_overlay")
        column = layout.column()
        column.active = settings.show_overlay
        for name in ("show_chart", "show_field"):
            column.prop(settings, name)


# in the order of work; calibration, device and experiment come last
_SIDEBAR = (
    DIMPLE_PT_session, DIMPLE_PT_readout, *materials.SIDEBAR, DIMPLE_PT_fingertips, DIMPLE_PT_animate,
    DIMPLE_PT_display, *calibration.SIDEBAR, *device.SIDEBAR, *experiment.SIDEBAR,
)  # fmt: skip
register, unregister = bpy.utils.register_classes_factory(
    [*materials.PROPERTIES, *physics_panels.PROPERTIES, *_SIDEBAR]
)
