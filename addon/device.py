"""The haptic device in the sidebar: its port and workspace, its state, and how much of a material it can render."""


import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, StringProperty

from ..operators.names import Op
from ..operators.press import haptic_fingertips
from .panel_parts import SidebarPanel, draw_notes, draw_rows
from .readout import iface_

_FIXED = {"options": set()}
FULL = 0.95  # fraction of the peak force: a larger force is shown as full
LATE = 1.05  # mean delay, in ticks of the device, from which late answers make a wall 3 % softer or more


class DeviceChoice:
    """The settings of this computer that choose its device; no scene has them, because a file may come from anybody."""

    device_port: StringProperty(
        name="Port", description="Where the device is plugged in: a serial port, a path, udp:HOST:PORT, "
                                  "or haply:PORT",
        search=lambda _settings, _context, _text: haptic_fingertips.ports(), search_options={"SORT", "SUGGESTION"},
    )  # fmt: skip
    device_secret: StringProperty(
        name="Device Secret", description="Secret that a network device shares with Dimple to identify itself. "
                                          "Without it, nobody can move your hand",
        subtype="PASSWORD",
    )  # fmt: skip
    device_anywhere: BoolProperty(
        name="Devices on Other Computers", description="Also connect to devices on other computers of the network, "
                                                       "if Blender allows online access",
    )  # fmt: skip


class DevicePlace:
    """The settings of a scene that place the workspace of the device."""

    device_scale: FloatProperty(
        name="Workspace Scale", description="Scale from hand motion to scene motion: at 2, a fingertip moves twice as "
                                            "far as your hand",
        default=1.0, min=0.01, soft_min=0.1, soft_max=10.0, precision=2, **_FIXED,
    )  # fmt: skip
    device_origin: FloatVectorProperty(
        name="Origin",
        description="Point in the scene where the fingertips are when the device is at its calibrated position",
        subtype="XYZ",
        **_FIXED,
    )
    device_centre_mm: FloatVectorProperty(
        name="Center (mm)", description="Position of the device that corresponds to the origin in the scene",
        subtype="XYZ", **_FIXED,
    )


class DIMPLE_PT_device(SidebarPanel, bpy.types.Panel):
    """Connect, arm and watch the haptic device."""

    bl_label = "Haptic Device"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout, connection = context.scene.dimple, self.layout, haptic_fingertips.get()
        layout.use_property_split = True
        if chosen := haptic_fingertips.choice():
            which = layout.column()
            which.enabled = connection is None
            which.prop(chosen, "device_port")
            if chosen.device_port.startswith("udp:"):
                which.prop(chosen, "device_secret")
        layout.prop(settings, "device_scale", text="Scale")
        layout.prop(settings, "device_origin")
        layout.operator(Op.CENTRE_DEVICE, icon="PIVOT_CURSOR")
        icon = "UNLINKED" if connection else "LINKED"
        layout.operator(Op.CONNECT_DEVICE, text="Disconnect" if connection else "Connect", icon=icon)
        row = layout.row(align=True)
        row.operator(Op.ARM_DEVICE, icon="PLAY")
        row.operator(Op.DISARM_DEVICE, icon="CANCEL")
        if connection is None:
            return
        body = context.object
        material = body.active_material.dimple if body and body.active_material else None
        draw_rows(layout, rows(connection.report, material))
        draw_notes(context, layout, notes(connection.report, material))
        if connection.report.note:
            draw_notes(context, layout, [connection.report.note], "ERROR")


def state(report: object) -> str:
    """Return a word for the state of the device."""
    if report.link.name == "READY":
        words = {
            "OFF": iface_("Ready, no force"), "WAITING": iface_("Hold Shift"),
            "ASKED": iface_("Arming"), "RAMP": iface_("Arming"), "ON": iface_("Armed"),
        }  # fmt: skip
        return words[report.arming.name]
    return {"OPENING": iface_("Connecting"), "LOST": iface_("Lost"), "REFUSED": iface_("Refused")}[report.link.name]


def rows(report: object, material: bpy.types.PropertyGroup | None) -> list[tuple[str, str]]:
    """Return rows (label, number with unit) of what the device measures and renders."""
    lines = [(iface_("State"), state(report))]
    if report.link.name != "READY":
        return lines
    lines.append((iface_("Rate"), f"{report.rate:.0f} Hz"))
    lines.append((iface_("Delay"), f"{1e3 * report.delay:.2f} ms"))
    lines.append((iface_("Lost Frames"), f"{report.lost + report.unsent}"))
    for number, tip in enumerate(report.tips, start=1):
        force = sum(c * c for c in tip.force) ** 0.5
        full = f" ({iface_('full')})" if tip.full or force > FULL * report.peak else ""
        lines.append((iface_("Force {}").format(number), f"{force:.2f} N{full}"))
    lines.append((iface_("Renders up to"), f"{report.cap / 1e3:.2f} N/mm, {report.peak:.0f} N"))
    for name, cap in _caps(report, material).items() if material else ():
        measured = getattr(material, name)
        rendered = min(measured, cap)
        lines.append((iface_("{} Material / Rendered").format(name), f"{measured:.2f} / {rendered:.2f} N/mm"))
    return lines


def notes(report: object, material: bpy.types.PropertyGroup | None) -> list[str]:
    """Return sentences on what the device cannot render, and what to do next."""
    if report.link.name != "READY":
        return []
    sentences = []
    caps = _caps(report, material) if material else {}
    softer = [name for name, cap in caps.items() if getattr(material, name) > cap]
    if softer:
        said = iface_("{} cannot be rendered without shaking, so the object feels softer than its material.")
        sentences.append(said.format(", ".join(softer)))
        if report.delay * report.rate > LATE:
            sentences.append(iface_("Late answers make it feel softer still. Connect the device over a network."))
    if material and knee_force(material) > report.peak:
        sentences.append(iface_("At its knee the material needs more force than the device can exert."))
    if report.arming.name == "WAITING":
        sentences.append(iface_("The force turns on once you hold Shift and the fingertips touch nothing."))
    sentences += slow()
    if not haptic_fingertips.sessions.sessions:
        sentences.append(iface_("Press Play to feel the selected object."))
    return sentences


def knee_force(material: bpy.types.PropertyGroup) -> float:
    """Return the force [N] of a material at its knee."""
    from ..core.material import law_force  # imported late, so that enabling is quick

    return law_force(material.x0, material.K1, material.K2, material.x0, _power(material))


def _caps(report: object, material: bpy.types.PropertyGroup) -> dict[str, float]:
    """Return the largest K1 and K2 [N/mm] whose law is nowhere steeper than the device can render."""
    return {"K1": report.cap / 1e3 / _power(material) ** 2, "K2": report.cap / 1e3}


def _power(material: bpy.types.PropertyGroup) -> float:
    from ..core.material import law_power

    return law_power(material.K1, material.K2, material.fill.lower(), material.tip.lower())


def slow() -> list[str]:
    """Return a sentence if Blender is too slow for the dead-man key, else nothing."""
    connection = haptic_fingertips.get()
    if not (connection and connection.slow):
        return []
    return [iface_("Blender draws too slowly: the dead-man key times out and there is no force. Simulate a proxy.")]


SIDEBAR = (DIMPLE_PT_device,)
