"""The haptic device beside the sessions: its fingertips press what runs, and feel what they press.

What runs does not need the device: when it is lost the sessions go on, and the panel says so. The connection itself
is kept in `sessions`, with all that is mutable.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from . import sessions

if TYPE_CHECKING:
    from ..core.haptics.contact_model import Contact
    from ..core.haptics.contact_rendering import Felt, Workspace
    from ..core.haptics.device import Device
    from ..core.haptics.messages import Report
    from ..core.session import Finger
    from .sessions import Body

EMULATED = "emulated"  # instead of a port: try it without a device
LOOK_S = 0.1  # between two looks at the device while nothing runs


@dataclass(slots=True, kw_only=True, eq=False)
class Connection:
    """Hold a device that is connected.

    report: what it said last.  watch: of the operator that follows the dead-man key.  felt: of each body.  places: of
    the device in the space of each body, for each of its fingertips, and its radius [mm].  news: a sentence for the
    artist that was not said yet.  read_at: when it was looked at last [s].
    """

    device: Device
    report: Report
    watch: object = None
    felt: dict[Body, Felt] = field(default_factory=dict)
    places: dict[tuple[Body, int], tuple[Workspace, float]] = field(default_factory=dict)
    news: str = ""
    read_at: float = 0.0


def get() -> Connection | None:
    """Return the device, None where none is connected."""
    return sessions.devices[0] if sessions.devices else None


def connect(scene: bpy.types.Scene) -> Connection:
    """Connect the device of a scene, and look at it from now on.

    Raises:
        DimpleError: it cannot be started, with the reason and what to do.
    """
    from ..core.base import DimpleError
    from ..core.haptics.device import Emulated, HapticMaster
    from ..core.haptics.hand import poking_hand

    disconnect()
    port = scene.dimple.device_port.strip()
    if not port:
        raise DimpleError('Choose a port, or type its path; "emulated" is a device to try.')
    file = Path(bpy.path.abspath(scene.dimple.device_file)) if scene.dimple.device_file else None
    if port.lower() == EMULATED:
        device: Device = Emulated(hand=poking_hand(), spec_path=file)
    else:
        device = HapticMaster(bpy.path.abspath(port), spec_path=file)
    device.open()
    connection = Connection(device=device, report=device.read())
    sessions.devices.append(connection)
    bpy.app.timers.register(_look, first_interval=LOOK_S, persistent=False)
    return connection


def disconnect() -> None:
    """Let go of the device; without one nothing happens."""
    while sessions.devices:
        sessions.devices.pop().device.close()
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)


def hold(seconds: float) -> None:
    """Hold the dead-man switch for some seconds from now; 0 releases it."""
    if connection := get():
        connection.device.hold(time.perf_counter() + seconds)


def read() -> list[str]:
    """Take the newest of the device; return sentences for the artist."""
    from ..core.haptics.messages import Link
    from ..core.haptics.safety import Arming

    connection = get()
    if connection is None:
        return []
    before, connection.report, connection.read_at = connection.report, connection.device.read(), time.perf_counter()
    report = connection.report
    ended = report.link is not before.link and report.link in (Link.LOST, Link.REFUSED)
    if ended or (report.arming is not before.arming and report.arming is Arming.OFF and report.message):
        connection.news = report.message
    said, connection.news = connection.news, ""
    return [said] if said else []


def place(scene: bpy.types.Scene, scale: float) -> Workspace:
    """Return where the device is in a session of a physical scale [m per scene unit]."""
    from ..core.haptics.contact_rendering import Workspace

    settings = scene.dimple
    grown = settings.device_scale
    x, y, z = (
        scale * at - grown * centre / 1e3
        for at, centre in zip(settings.device_origin, settings.device_centre_mm, strict=True)
    )
    return Workspace(origin=(x, y, z), scale=grown)


def fingertips(scene: bpy.types.Scene, body: Body) -> list[Finger | None]:
    """Return the device's fingertips in a session's space; none where no device is ready."""
    from ..core.haptics.contact_rendering import fingers
    from ..core.haptics.messages import Link

    connection = get()
    if connection is None or connection.report.link is not Link.READY:
        return []
    return fingers(connection.report, place(scene, body.link.scale), scene.dimple.finger_radius_mm / 1e3)


def write(scene: bpy.types.Scene) -> None:
    """Let each fingertip feel the body that it is deepest in, or nearest to.

    What is put under a fingertip at once, by a new session, another place of the device, another radius or the end of a
    poke, must not push, as when it is armed: else it is disarmed.
    """
    from ..core.haptics.contact_rendering import Felt
    from ..core.haptics.messages import Link
    from ..core.haptics.safety import QUIET_FORCE

    connection = get()
    if connection is None or connection.report.link is not Link.READY:
        return
    radius = scene.dimple.finger_radius_mm
    now, chosen, places, kicks = time.perf_counter(), [], {}, False
    for body in sessions.sessions.values():
        felt, where = connection.felt.setdefault(body, Felt()), place(scene, body.link.scale)
        contacts = felt.contacts(body.session, where, connection.report.cap, now, body.poked)
        chosen = nearer(chosen, contacts)
        pushed = [i for i, contact in enumerate(contacts) if contact and math.hypot(*contact.force) >= QUIET_FORCE]
        kicks |= any(connection.places.get((body, i)) != (where, radius) for i in pushed)
        places |= {(body, i): (where, radius) for i in range(len(contacts)) if i not in body.poked}
    if kicks and connection.report.arming.name != "OFF":
        connection.device.disarm()
        connection.news = "What is under a fingertip has changed. Lift it and arm the device again."
    connection.felt = {body: felt for body, felt in connection.felt.items() if body in sessions.sessions.values()}
    connection.places = places
    connection.device.write(chosen)


def nearer(some: Sequence[Contact | None], others: Sequence[Contact | None]) -> list[Contact | None]:
    """Return of two contacts of each fingertip the one that presses more, or else has the smaller gap."""
    pairs = [(a, b) for a, b in zip([*some, *[None] * 3][:3], [*others, *[None] * 3][:3], strict=True)]
    return [min((c for c in pair if c), key=_order, default=None) for pair in pairs]


def _order(contact: Contact) -> tuple[float, float]:
    return contact.gap, -sum(c * c for c in contact.force)


def set_origin(scene: bpy.types.Scene) -> None:
    """Let the middle of the fingertips, where they are now, be at the 3D cursor.

    Raises:
        DimpleError: the device does not know where they are.
    """
    from ..core.base import DimpleError

    connection = get()
    tips = [tip.position for tip in connection.report.tips if not tip.masked] if connection else []
    if not tips:
        raise DimpleError("The device is not ready. Connect it and wait until the panel says so.")
    settings = scene.dimple
    settings.device_centre_mm = [1e3 * sum(tip[c] for tip in tips) / len(tips) for c in range(3)]
    settings.device_origin = scene.cursor.location


def _look() -> float | None:
    """Keep the panel up to date; while nothing runs, or what runs is paused, nobody else does."""
    connection, now = get(), time.perf_counter()
    if connection is None:
        return None
    if now - connection.read_at > LOOK_S:
        said = read()
        if sessions.sessions:
            connection.news = " ".join(said)  # for when it goes on
            connection.device.renew()
        else:
            connection.device.write([])
    sessions.redraw()
    return LOOK_S


def ports() -> list[tuple[str, str]]:
    """Return what there is to connect: paths with what they call themselves."""
    from ..core.haptics.serial_link import ports

    return [*ports(), (EMULATED, "")]


@bpy.app.handlers.persistent
def _on_load_pre(*_: object) -> None:
    disconnect()


def register() -> None:
    """Listen to Blender."""
    bpy.app.handlers.load_pre.append(_on_load_pre)


def unregister() -> None:
    """Let go of the device and stop listening."""
    disconnect()
    bpy.app.handlers.load_pre.remove(_on_load_pre)
