"""Poke: press with mouse or pen, live and without the timeline; or press from a script at a given place and depth."""

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty

from ...core.errors import DimpleError
from ..names import Op
from ..reporting import report, say
from . import fingertip_objects, modal_runs, polls, sessions, showing
from .play import Driving

if TYPE_CHECKING:
    from ...core.poke import PokeEvent, PokeState
    from .poke_input import View

_CONTACT = ("collider", "collider_friction", "is_prop", "prop_mass_kg", "self_contact")


class DIMPLE_OT_poke(Driving, bpy.types.Operator):
    """Press the selected meshes with a fingertip: live with the mouse, or from a script at a given place"""

    bl_idname = Op.POKE
    bl_label = "Poke"
    bl_options = {"UNDO"}

    location: FloatVectorProperty(
        name="Location", description="Where to press [scene units]; by default the top of the body", subtype="XYZ"
    )
    direction: FloatVectorProperty(
        name="Direction", description="Direction of the press; 0 presses straight into the surface",
        subtype="XYZ",
    )  # fmt: skip
    depth_mm: FloatProperty(name="Depth (mm)", description="How deep to press", default=15.0, min=0.01, soft_max=200.0)
    force_n: FloatProperty(
        name="Force (N)", description="Force to press with; 0 presses to the depth instead", default=0.0, min=0.0,
        soft_max=100.0,
    )  # fmt: skip
    press_s: FloatProperty(
        name="Press (s)", description="Time the fingertip takes to go in", default=0.25, min=0.0, soft_max=5.0
    )
    hold_s: FloatProperty(name="Hold (s)", description="Time at full depth", default=0.25, min=0.0, soft_max=5.0)
    release_s: FloatProperty(
        name="Release (s)", description="Time the fingertip takes to come out; 0 stays pressed",
        default=0.25, min=0.0, soft_max=5.0,
    )  # fmt: skip
    radius_mm: FloatProperty(
        name="Radius (mm)", description="Radius of the fingertip; 0 uses that of the scene", default=0.0, min=0.0
    )
    finger: IntProperty(
        name="Finger", description="Fingertip to press with: 1, 2 or 3; 0 uses that of the scene", default=0, min=0,
        max=3,
    )  # fmt: skip
    keep: BoolProperty(name="Keep", description="Keep the dent at the end instead of restoring the rest shape")

    needs = (
        polls.in_object_mode,
        polls.need(lambda _: all(run.kind != "poke" for run in modal_runs.runs), "A poke is running; Esc ends it"),
        polls.is_free,
    )

    def run(self, context: bpy.types.Context) -> None:
        from . import scripted_press

        scripted_press.press_once(self, context)

    def begin(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ...core.poke import PokeState
        from ..bridge import sizing
        from . import live_step, poke_input

        view = poke_input.view_under(context, event)
        clicked = view if event.type == "LEFTMOUSE" and event.value in poke_input.DOWN else None  # started by the tool
        if clicked and self._chosen(context, clicked):
            return {"CANCELLED"}
        found = poke_input.under(context, clicked) if clicked else None
        if clicked and found is None:
            return {"PASS_THROUGH"}  # an ordinary click, which selects
        if found and not found.obj.select_get():
            fingertip_objects.select(context, found.obj)
        if self.starts_later(context):
            return {"CANCELLED"}
        sizing.fit(context.scene, found.obj if found else live_step.candidates(context)[0])
        self._tool = settings_of(context.scene)
        self._state = PokeState(**self._tool)
        self.start(context)
        self._shapes: dict[int, object] = {}
        result = self.drive(context, "poke")
        self._before = undoable(context.scene)
        modal_runs.show_status(context, self._run, self._help(context))
        if clicked:
            self._take(context, poke_input.poke_event(event, clicked, sessions.sessions, {}, pressing=False))
        else:
            poke_input.choose_tool(context)  # for its keys and its circle
        return result

    def handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ...core.poke import Kind
        from . import poke_input

        if event.type == "TIMER":
            return self._tick(context)
        if context.mode != "OBJECT" and event.type != "ESC":
            return {"PASS_THROUGH"}  # weights are being painted; the fingertips stay where they are
        view = poke_input.view_under(context, event)
        pressing = self._state.pressing
        meant = poke_input.poke_event(event, view, sessions.sessions, self._shapes, pressing=pressing)
        if meant is None:
            passes = poke_input.passes(event, view, pressing=pressing, undo=self._before != undoable(context.scene))
            return {"PASS_THROUGH"} if passes else {"RUNNING_MODAL"}
        if view and meant.kind is Kind.PRESS and self._chosen(context, view):
            return {"CANCELLED"}
        if view and meant.kind is Kind.PRESS and meant.hit is None:
            meant = self._joined(context, event, view)
            if meant is None:
                return {"PASS_THROUGH"}  # a click beside the bodies selects
        return self._take(context, meant)

    def _chosen(self, context: bpy.types.Context, view: "View") -> bool:
        """If a fingertip object is clicked, leave the poke, select the object for Blender's tools and return True."""
        from . import poke_input

        tip = poke_input.fingertip_under(context, view)
        if tip is None:
            return False
        fingertip_objects.leave_poke()
        fingertip_objects.select(context, tip)
        if bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message="Select")
        return True

    def _tick(self, context: bpy.types.Context) -> set[str]:
        """Simulate the wall time since the last timer event, or as much of it as the computer manages."""
        from ...core.poke import Kind, PokeEvent, on_event
        from . import live_step

        asked, self._budget = live_step.ask(context.scene, self._run, self.passed())
        tool = settings_of(context.scene)
        self._state, self._tool = taken(self._state, self._tool, tool), tool
        modal_runs.show_status(context, self._run, self._help(context))
        report(self, modal_runs.save_when_due(self._run))
        if self._run.paused:
            return self.went_on(showing.end_changed(context.view_layer)) or {"PASS_THROUGH"}
        self._state = on_event(self._state, PokeEvent(kind=Kind.TICK, amount=asked))
        return self._step(context, asked) or {"PASS_THROUGH"}

    def _take(self, context: bpy.types.Context, event: "PokeEvent") -> set[str]:
        """Update the state by an event, and carry out the event."""
        from ...core.poke import Kind, on_event

        was_pressing = self._state.pressing
        self._state = on_event(self._state, event)
        if event.kind is Kind.PAUSE:
            self._run.paused = not self._run.paused
            modal_runs.redraw()
        if self._state.pressing and not was_pressing:
            # a drag follows the surface before the press: following its own dent, it would go deeper and deeper
            self._shapes = {uid: body.session.positions() for uid, body in sessions.sessions.items()}
        if event.kind is Kind.FINGER:
            context.scene.dimple.active_finger = self._state.active + 1
            self._tool["active"] = self._state.active
        if event.kind in (Kind.KEEP, Kind.LEAVE):
            sessions.stop_all(restore=event.kind is Kind.LEAVE)
            return {"FINISHED"} if event.kind is Kind.KEEP else {"CANCELLED"}
        return {"RUNNING_MODAL"}

    def _step(self, context: bpy.types.Context, dt: float) -> set[str] | None:
        """Advance the sessions by a time [s]; return the result that ends the operator if no session is left."""
        from ...core.poke import fingers, lifted
        from ..bridge import object_link, sizing
        from . import live_step

        pressed = {uid: fingers(self._state, uid) for uid in sessions.sessions}
        scales = {uid: body.link.scale for uid, body in sessions.sessions.items()}
        messages = live_step.advance(context, dt, budget=self._budget, pressed=pressed)
        for uid, body in sessions.sessions.items():
            if body.link.scale != scales[uid]:
                self._state = lifted(self._state, uid)
                sizing.fit(context.scene, object_link.find(uid, body.name))
        live_step.adapt(self._run, dt)
        return self.went_on(messages)

    def _joined(self, context: bpy.types.Context, event: bpy.types.Event, view: "View") -> "PokeEvent | None":
        """Start the session of an unselected soft body that is pressed; return the press, or None if there is none."""
        from . import poke_input

        found = poke_input.under(context, view)
        if found is None or not found.obj.dimple.enabled or sessions.get(found.obj):
            return None
        try:
            body, messages = sessions.start(found.obj, context)
        except DimpleError as error:
            say(self, {"WARNING"}, str(error))
            return None
        self._before[body.link.uid] = undoable(context.scene)[body.link.uid]
        report(self, messages)
        return poke_input.poke_event(event, view, sessions.sessions, {}, pressing=False)

    def _help(self, context: bpy.types.Context) -> str:
        if context.mode != "OBJECT":
            return polls.tip_("The fingertips stay where they are | Esc: end the poke")
        return help_text(self._state, paused=self._run.paused)


def undoable(scene: bpy.types.Scene) -> dict[int, object]:
    """Return the settings of the fingertip, and of each object by session_uid: if they have changed since the poke
    began, undo may take a step back.
    """
    from ..bridge import body_model

    tool = settings_of(scene)
    del tool["active"]  # chosen by a key, which is no undo step
    return {0: tool} | {
        obj.session_uid: (body_model.settings_of(scene, obj), *(getattr(obj.dimple, name) for name in _CONTACT))
        for obj in scene.objects
    }


def settings_of(scene: bpy.types.Scene) -> dict[str, float]:
    """Return the scene's settings of the fingertip by their names in `PokeState`, in SI units."""
    stored = scene.dimple
    return {
        "radius": stored.finger_radius_mm / 1e3,
        "depth": stored.press_depth_mm / 1e3,
        "force": stored.press_force_n,
        "by_force": stored.press_by == "FORCE",
        "active": stored.active_finger - 1,
    }


def taken(state: "PokeState", before: dict[str, float], now: dict[str, float]) -> "PokeState":
    """Return a state with the settings that changed in the panels; the active finger changes only between presses."""
    from ...core.poke import with_settings

    changed = {name: value for name, value in now.items() if value != before[name]}
    active = int(changed.pop("active", state.active))
    if changed:
        state = with_settings(state, **changed)
    return state if state.pressing else replace(state, active=active)


def help_text(state: "PokeState", *, paused: bool) -> str:
    """Return the help on the keys for the status bar."""
    if state.by_force:
        amount, text = f"{state.force:.3g} N", polls.tip_("Left drag: press with {} | F: radius {} | Ctrl F: force")
    else:
        amount = f"{1e3 * state.depth:.3g} mm"
        text = polls.tip_("Left drag: press {} deep | F: radius {} | Ctrl F: depth")
    keys = (
        polls.tip_("1 2 3: finger"),
        polls.tip_("Space: go on") if paused else polls.tip_("Space: pause"),
        polls.tip_("Enter: keep | Esc: leave"),
    )
    return " | ".join((text.format(amount, f"{1e3 * state.radius:.3g} mm"), *keys))
