"""The haptic device: its fingertips press the running bodies, and it renders the force on them.

The sessions do not need the device: if the connection is lost they continue, and the panel says so. The connection is
kept here; `sessions` does not know of it, but calls `disarm` before it ends anything.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy

from ...core.errors import DimpleError
from ...core.message import Message, in_a_row
from . import modal_runs, sessions

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...core.body.model import Model
    from ...core.device.device import Device
    from ...core.device.orders import ServoReport
    from ...core.device.rendered_surface import Law
    from ...core.device.workspace import Workspace
    from ...core.session import Finger
    from .sessions import LiveBody

SLOW_S = 0.25  # [s] longest interval between frames of Blender for which the dead-man key does not lapse (limits.LEASE)
LOOK_S = 0.1  # [s] interval at which the device is read while nothing runs
_PACKAGE = (__package__ or "").partition(".operators")[0]


@dataclass(slots=True, kw_only=True, eq=False)
class Connection:
    """A connected device."""

    device: Device  # the open device
    report: ServoReport  # its last report
    watch: object = None  # token of the operator that follows the dead-man key
    # by body, index of the fingertip, the device's workspace in the space of the body, and radius of the fingertips
    # [mm]: model and law at the fingertip in the last frame; only a new combination, or a new model, can kick
    known: dict[tuple[LiveBody, int, Workspace, float], tuple[Model, Law | None]] = field(default_factory=dict)
    note: str = ""  # a sentence for the artist that has not been shown yet
    read_at: float = 0.0  # time of the last reading [s]
    slow: bool = False  # Blender draws too slowly for the dead-man key


connections: list[Connection] = []  # the connected device, or empty
watching: list[Callable[[Connection], None]] = []  # functions called after each reading, such as that of a blind trial


def get() -> Connection | None:
    """Return the connected device, or None."""
    return connections[0] if connections else None


def disarm() -> None:
    """End all force of the device, if one is connected."""
    if connection := get():
        connection.device.disarm()


def choice() -> bpy.types.AddonPreferences | None:
    """Return the preferences, which name the device, or None if Blender does not list the extension."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    return addon.preferences if addon else None


def connect() -> Connection:
    """Connect the device that the preferences name, and read it from now on.

    Raises:
        DimpleError: the device cannot be started, with the reason and what to do.
    """
    from ...core.device.device import Device

    disconnect()
    chosen = choice()
    port = chosen.device_port.strip() if chosen else ""
    if not port:
        raise DimpleError("Choose a port, or type its path.")
    device = Device(
        bpy.path.abspath(port),
        secret=chosen.device_secret.strip(),
        anywhere=chosen.device_anywhere and bpy.app.online_access,
    )
    device.open()
    connection = Connection(device=device, report=device.read())
    connections.append(connection)
    bpy.app.timers.register(_look, first_interval=LOOK_S, persistent=False)
    return connection


def disconnect() -> None:
    """Disconnect the device, if one is connected."""
    while connections:
        connections.pop().device.close()
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)


def hold(seconds: float) -> None:
    """Keep the dead-man key held for some seconds from now; 0 releases it."""
    if connection := get():
        connection.device.hold(time.perf_counter() + seconds)


def read() -> list[str]:
    """Read the device; return sentences for the artist."""
    from ...core.device.force_guard import Arming
    from ...core.device.orders import LinkState

    connection = get()
    if connection is None:
        return []
    gap = time.perf_counter() - connection.read_at if connection.read_at else 0.0
    before, connection.report, connection.read_at = connection.report, connection.device.read(), time.perf_counter()
    for watch in watching:
        watch(connection)
    report = connection.report
    armed = report.link is LinkState.READY and report.arming is not Arming.OFF
    if gap > SLOW_S and armed and not connection.slow:
        connection.slow, connection.note = True, Message(
            "Blender draws only {rate:.1f} frames a second, so the dead-man key times out and there is no force. "
            "Simulate a proxy, or simplify the view.",
            rate=1 / gap
        )  # fmt: skip
    elif gap < SLOW_S / 2 or not armed:
        connection.slow = False
    ended = report.link is not before.link and report.link in (LinkState.LOST, LinkState.REFUSED)
    if ended or (report.arming is not before.arming and report.arming is Arming.OFF and report.note):
        connection.note = report.note
    note, connection.note = connection.note, ""
    return [note] if note else []


def workspace(scene: bpy.types.Scene, scale: float) -> Workspace:
    """Return the workspace of the device in a session with a physical scale [m per scene unit]."""
    from ...core.device.workspace import Workspace

    settings = scene.dimple
    enlarged = settings.device_scale
    x, y, z = (
        scale * at - enlarged * centre / 1e3
        for at, centre in zip(settings.device_origin, settings.device_centre_mm, strict=True)
    )
    return Workspace(origin=(x, y, z), scale=enlarged)


def fingertips(scene: bpy.types.Scene, body: LiveBody) -> list[Finger | None]:
    """Return the device's fingertips in a session's space; empty if no device is ready."""
    from ...core.device.orders import LinkState
    from ...core.device.workspace import fingers

    connection = get()
    if connection is None or connection.report.link is not LinkState.READY:
        return []
    return fingers(connection.report, workspace(scene, body.link.scale), scene.dimple.finger_radius_mm / 1e3)


def write(scene: bpy.types.Scene) -> None:
    """Send the device the surface under each fingertip, that of the body in which the fingertip is deepest.

    A new session, a moved workspace, a changed radius or the end of a poke may suddenly put a body under a fingertip,
    and an edit may make its material, or what is painted on it, stiffer. If it then pushes harder than it would have
    without that change at the same depth, the device is disarmed instead of kicking.
    """
    from ...core.device.limits import QUIET_FORCE
    from ...core.device.orders import LinkState
    from ...core.device.wire import FINGERS
    from ...core.device.workspace import surfaces_of

    connection = get()
    if connection is None or connection.report.link is not LinkState.READY:
        return
    now, radius, known, kicks = time.perf_counter(), scene.dimple.finger_radius_mm, {}, False
    deepest, surfaces = [-math.inf] * FINGERS, [None] * FINGERS
    for body in sessions.sessions.values():
        where, touches = workspace(scene, body.link.scale), body.frame.touches
        for i, surface in enumerate(surfaces_of(body.session, touches, where, now)):
            if i in body.poked:
                continue
            which, model = (body, i, where, radius), body.session.model
            same, law = connection.known.get(which, (None, None))
            if same is not model and surface:
                depth, whole = touches[i].depth / where.scale, math.hypot(*touches[i].force)
                old, new = (each.force(depth, math.inf) if each else 0.0 for each in (law, surface.law))
                kicks |= new > 0 and whole * (1 - old / new) >= QUIET_FORCE * where.scale
            known[which] = model, surface and surface.law
            if surface and touches[i].depth > deepest[i]:
                deepest[i], surfaces[i] = touches[i].depth, surface
    if kicks and connection.report.arming.name != "OFF":
        connection.device.disarm()
        connection.note = "The surface under a fingertip has changed. Lift the fingertip and arm the device again."
    connection.known = known
    connection.device.write(surfaces)


def set_origin(scene: bpy.types.Scene) -> None:
    """Move the workspace so that the current centre of the fingertips is at the 3D cursor.

    Raises:
        DimpleError: the positions of the fingertips are unknown.
    """
    connection = get()
    tips = [tip.position for tip in connection.report.tips if not tip.masked] if connection else []
    if not tips:
        raise DimpleError("The device is not ready. Connect it and wait until the panel says so.")
    settings = scene.dimple
    settings.device_centre_mm = [1e3 * sum(tip[c] for tip in tips) / len(tips) for c in range(3)]
    settings.device_origin = scene.cursor.location


def _look() -> float | None:
    """Keep the panel up to date while no session runs or time is paused."""
    connection, now = get(), time.perf_counter()
    if connection is None:
        return None
    if now - connection.read_at > LOOK_S:
        notes = read()
        if sessions.sessions:
            connection.note = in_a_row(notes)  # to be shown when time runs again
            connection.device.renew()
        else:
            write(bpy.context.scene)
    modal_runs.redraw()
    return LOOK_S


def ports() -> list[tuple[str, str]]:
    """Return the ports that can be connected, as paths and descriptions."""
    from ...core.device import haply_line, udp_line
    from ...core.device.serial_line import ports

    return [*ports(), (haply_line.EXAMPLE, "Haply Inverse3"), (udp_line.EXAMPLE, "Network")]


@bpy.app.handlers.persistent
def _on_load_pre(*_: object) -> None:
    disconnect()


def register() -> None:
    sessions.disarming.append(disarm)
    bpy.app.handlers.load_pre.append(_on_load_pre)


def unregister() -> None:
    disconnect()
    sessions.disarming.remove(disarm)
    bpy.app.handlers.load_pre.remove(_on_load_pre)
