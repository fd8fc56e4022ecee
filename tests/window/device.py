"""The window test's haptic device, inside Blender: that of the test bench presses the ball and is lost; it plays on."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import bpy
import robot

BENCH = Path(__file__).resolve().parents[1] / "studies" / "bench" / "start.py"  # beside this folder, see run.py
PRESSED = 0.3  # [N]
TAB = "Device"
STOPPED_S = 0.4  # longer than the dead-man key counts as held


def open_panel(name: str = "DIMPLE_PT_device", tab: str = TAB) -> type:
    """Draw a panel once more, open, in a tab of its own; who was drawn closed stays so."""
    if made := getattr(bpy.types, f"{name}_open", None):
        return made
    panel = getattr(bpy.types, name)
    place = {name: getattr(panel, name) for name in ("bl_space_type", "bl_region_type")}
    shown = {"bl_label": f"{panel.bl_label} (open)", "bl_category": tab, "draw": panel.draw}
    if hasattr(panel, "poll"):
        shown["poll"] = classmethod(lambda _cls, context: panel.poll(context))
    made = type(f"{name}_open", (bpy.types.Panel,), {**place, **shown})
    bpy.utils.register_class(made)
    return made


def photograph(path: Path, draws: int = 2) -> robot.Waits:
    """Take a picture of what is drawn now."""
    robot.region("UI").tag_redraw()
    yield from robot.redrawn(draws)
    robot.screenshot(path)


def feel(body: str, top: tuple[float, float, float], out: Path, check: Callable[..., None]) -> robot.Waits:
    """Connect an emulated device, let it press the playing body; kill its servo; stop."""
    rest = robot.positions(body).copy()
    device, settings = robot.extension("operators.press.haptic_fingertips"), bpy.context.scene.dimple
    processes, port = robot.extension("core.device.process"), out / "haptic"
    emulator = processes.start(["emulator", "--lifeline", "--pty", str(port)], None, script=BENCH)
    yield from robot.until(port.exists, "the emulated device has a port", 60)
    device.choice().device_port, settings.device_origin = str(port), top
    panel = open_panel()
    bpy.ops.dimple.connect_device()

    def report() -> object:
        return device.get().report

    def strongest() -> float:
        return max(sum(c * c for c in tip.force) ** 0.5 for tip in report().tips)

    yield from robot.until(lambda: report().states > 10, "the emulated device answers", 60)
    with robot.inside():
        bpy.ops.dimple.play("INVOKE_DEFAULT")

    def presses() -> bool:
        """Tell whether a fingertip presses; arm, again where a busy machine was disarmed for its gaps."""
        if report().arming.name == "OFF" and report().link.name == "READY":
            bpy.ops.dimple.arm_device(hold_s=600.0)
        return strongest() > PRESSED

    yield from robot.show_tab(TAB)
    # a frame drawn in software takes longer than the dead-man key counts as held: none is drawn until a tip presses
    place, most = robot.area(), 0.0
    for _ in range(5):
        place.type = "TEXT_EDITOR"
        yield from robot.until(presses, "a fingertip of the device feels the ball", 120)
        most = max(most, strongest())
        place.type = "VIEW_3D"
        yield from photograph(out / "12-device.png", draws=1)
        if strongest() > PRESSED:
            break  # it is seen pressing
    check("a fingertip of the emulated device feels the playing ball", most > PRESSED, f"{most:.2f} N")
    yield from too_slow(presses, out, check)
    device.get().device.process.kill()
    yield from robot.until(lambda: report().link.name == "LOST", "the loss of the device is seen", 60)
    playing = bool(robot.modal_operators())
    check(
        "a killed servo is reported, and the ball plays on", playing and "arm again" in report().note, report().note
    )
    yield from photograph(out / "13-device-lost.png")
    bpy.ops.dimple.connect_device()  # lets go of it
    processes.end(emulator)
    yield from robot.key("ESC", *robot.on_screen((0.0, 0.0, 0.0)))
    yield from robot.until(lambda: not robot.modal_operators(), "ESC ends the play", 30)
    yield from robot.show_tab("Dimple")
    bpy.utils.unregister_class(panel)
    yield from photograph(out / "14-device-gone.png")
    check("without the device the ball is as it was, bit for bit", (robot.positions(body) == rest).all())


def too_slow(armed: Callable[[], bool], out: Path, check: Callable[..., None]) -> robot.Waits:
    """Hold Blender up while the device is armed: that is said, and seen while it lasts, with the sidebar closed."""
    device, view = robot.extension("operators.press.haptic_fingertips"), robot.area().spaces.active
    view.show_region_ui = False

    def held_up() -> bool:
        armed()
        time.sleep(STOPPED_S)
        return device.get().slow

    yield from robot.until(held_up, "Blender is too slow for the device", 5)
    yield from photograph_view(out / "13-too-slow.png")
    reports = [each.message for each in bpy.context.window_manager.reports]
    said = [each for each in reports if each.startswith("Blender draws only")]
    check("a Blender too slow for the device says so", bool(said), said[-1] if said else "")
    view.show_region_ui = True
    yield from robot.redrawn()


def photograph_view(path: Path) -> robot.Waits:
    """Take a picture of the viewport while Blender stays slow."""
    drawn = robot.drawn()
    while robot.drawn() < drawn + 2:
        time.sleep(STOPPED_S)
        robot.area().tag_redraw()
        yield robot.TICK_S
    robot.screenshot(path)
