"""Connect a haptic device, arm and disarm it, and place it in the scene."""

import time

import bpy
from bpy.props import FloatProperty

from ..names import DEAD_MAN, Op
from ..press import haptic_fingertips, modal_runs, polls, sessions
from ..translation import translated

RENEW_S = 0.05  # [s] between two renewals of the dead-man key; `limits.LEASE` tolerates a stall of 0.2 s between them
KEYS = "Hold Shift: force | Esc: disarm"


is_ready = polls.need(
    lambda _: (connection := haptic_fingertips.get()) and connection.report.link.name == "READY",
    "No haptic device is ready",
)


class DIMPLE_OT_connect_device(polls.Declared, bpy.types.Operator):
    """Connect or disconnect the haptic device. It exerts no force until it is armed"""

    bl_idname = Op.CONNECT_DEVICE
    bl_label = "Connect"

    def run(self, _context: bpy.types.Context) -> None:
        if haptic_fingertips.get():
            haptic_fingertips.disconnect()
        else:
            haptic_fingertips.connect()


class DIMPLE_OT_arm_device(polls.Declared, bpy.types.Operator):
    """Let the device exert force while you hold Shift or its own button. Esc disarms it"""

    bl_idname = Op.ARM_DEVICE
    bl_label = "Arm"
    needs = (is_ready,)

    hold_s: FloatProperty(
        name="Hold (s)", description="For scripts: how long the dead-man key counts as held", default=0.0, min=0.0
    )

    def run(self, _context: bpy.types.Context) -> None:
        connection = haptic_fingertips.get()
        connection.watch = None
        haptic_fingertips.hold(self.hold_s)
        connection.device.arm()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Arm, and watch the dead-man key from now on."""
        connection = haptic_fingertips.get()
        self._watch = connection.watch = object()
        self._since, self._down = time.perf_counter(), False
        haptic_fingertips.hold(0.0)
        connection.device.arm()
        manager = context.window_manager
        self._timer = manager.event_timer_add(RENEW_S, window=context.window)
        manager.modal_handler_add(self)
        context.workspace.status_text_set(translated(KEYS))
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Watch the key: it counts as held from its press until an event shows otherwise. Esc or a lost device ends it.

        Every event carries the state of the modifier keys. Timers and the loss of focus reach every modal operator,
        whatever events another one consumes; without either the lease expires.
        """
        from ...core.device.limits import LEASE

        connection = haptic_fingertips.get()
        if connection is None or connection.watch is not self._watch or not self._is_armed(connection):
            return self._end(context)
        if event.type == "ESC" and event.value == "PRESS":
            connection.device.disarm()
            haptic_fingertips.hold(0.0)
            connection.watch = None
            return {"PASS_THROUGH"} if modal_runs.runs else self._end(context)
        before, key = self._down, event.value if event.type == DEAD_MAN else ""
        if key == "PRESS":
            self._down = True
        elif key == "RELEASE" or event.type == "WINDOW_DEACTIVATE" or not event.shift:
            self._down = False
        if event.type == "TIMER" or self._down != before:
            haptic_fingertips.hold(LEASE if self._down else 0.0)
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        sessions.disarm()
        self._end(context)

    def _is_armed(self, connection: haptic_fingertips.Connection) -> bool:
        """Return whether the device is armed, or may still report that it is."""
        from ...core.device.limits import ANSWER_TIME

        report = connection.report
        settled = time.perf_counter() - self._since > ANSWER_TIME
        return report.link.name == "READY" and not (settled and report.arming.name == "OFF")

    def _end(self, context: bpy.types.Context) -> set[str]:
        context.window_manager.event_timer_remove(self._timer)
        owner = connection.watch if (connection := haptic_fingertips.get()) else None
        if owner is self._watch:
            haptic_fingertips.hold(0.0)
        if owner in (None, self._watch):  # a newer operator shows its own text; a script shows none
            modal_runs.clear_status()
        return {"FINISHED"}


class DIMPLE_OT_disarm_device(polls.Declared, bpy.types.Operator):
    """End all force of the device at once"""

    bl_idname = Op.DISARM_DEVICE
    bl_label = "Disarm"
    needs = (is_ready,)

    def run(self, _context: bpy.types.Context) -> None:
        haptic_fingertips.hold(0.0)
        haptic_fingertips.get().device.disarm()


class DIMPLE_OT_centre_device(polls.Declared, bpy.types.Operator):
    """Place the center of your fingertips, as you hold the device now, at the 3D cursor"""

    bl_idname = Op.CENTRE_DEVICE
    bl_label = "Calibrate Origin"
    needs = (is_ready,)

    def run(self, context: bpy.types.Context) -> None:
        haptic_fingertips.set_origin(context.scene)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    [DIMPLE_OT_connect_device, DIMPLE_OT_arm_device, DIMPLE_OT_disarm_device, DIMPLE_OT_centre_device]
)


def register() -> None:
    _register_classes()
    haptic_fingertips.register()


def unregister() -> None:
    haptic_fingertips.unregister()
    _unregister_classes()
