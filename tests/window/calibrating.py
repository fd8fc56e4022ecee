"""Calibration in the window test: files are dropped, a question is asked, a table is pasted and fitted."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import clicking
import numpy as np
import robot

LAW = 0.6, 7.0, 12.0  # K1, K2 [N/mm], x0 [mm]

Check = Callable[..., None]


def press_file(header: str, air: float = 0.0) -> Path:
    """Write a press of the law above, with 1 % of noise, after some air [mm]."""
    depth = np.linspace(0, 20 + air, 81)
    x = np.maximum(depth - air, 0)
    force = LAW[0] * np.minimum(x, LAW[2]) + LAW[1] * np.maximum(x - LAW[2], 0)
    force = force + 0.01 * force.max() * np.random.default_rng(2).normal(size=len(depth))
    path = Path("/tmp") / ("cushion.csv" if header else "bare.csv")
    path.write_text(header + "".join(f"{x:.3f},{f:.4f}\n" for x, f in zip(depth, force, strict=True)))
    return path


def drop(path: Path) -> None:
    """Do what Blender does with a file that is let go over the viewport: ask its file handlers."""
    with robot.inside():
        bpy.ops.wm.drop_import_file("INVOKE_DEFAULT", directory=str(path.parent), files=[{"name": path.name}])


def calibrate(at: tuple[int, int], body: str, out: Path, check: Check) -> robot.Waits:
    """Drop two files, and give the result to the material."""
    scene = bpy.context.scene.dimple
    yield from robot.move(*at)
    yield from robot.redrawn()
    bare = robot.screenshot(out / "9-question.png")
    drop(press_file(""))
    yield from robot.redrawn()
    gap = robot.differing(bare, robot.screenshot(out / "9-question.png"), at, robot.HALF)
    check("a dropped file without a header is asked about", gap > robot.SEEN, f"{gap} pixels differ")
    yield from robot.key("ESC", *at)
    yield from robot.redrawn()
    check("a question that is left changes nothing", scene.calibration == "")
    drop(press_file("Distance x (mm),Force F (N)\n"))
    yield from robot.until(lambda: scene.calibration != "", "the dropped file is read", 30)
    with robot.inside():
        bpy.ops.dimple.apply_calibration("INVOKE_DEFAULT")
    settings = bpy.data.objects[body].active_material.dimple
    found = settings.K1, settings.K2, settings.x0
    text = "K1 {:.3f} N/mm, K2 {:.3f} N/mm, x0 {:.2f} mm".format(*found)
    check("a dropped file becomes a material", np.allclose(found, LAW, 0.05), text)
    yield from robot.redrawn()
    scale, view = bpy.context.preferences.system.ui_scale, robot.region()
    left, bottom, *_ = robot.free_room()
    wide, high = robot.extension("addon.force_chart").SIZE
    chart = round(view.x + left + wide * scale / 2), round(view.y + bottom + high * scale / 2)
    gap = robot.differing(bare, robot.screenshot(out / "9-calibrated.png"), chart, robot.HALF)
    check("its chart is seen in the viewport", gap > robot.SEEN, f"{gap} pixels differ")
    yield from drag_the_touch(out, check)
    yield from by_hand(at, body, out, check)


def record() -> dict:
    """Return the result in the scene, looked up each time: an undo frees what there was."""
    return json.loads(bpy.context.scene.dimple.calibration)


def drag_the_touch(out: Path, check: Check) -> robot.Waits:
    """Read a file with air before the touch, and drag the touch in the corner of the viewport."""
    path = press_file("Distance x (mm),Force F (N)\n", air=5.0)
    with bpy.context.temp_override(window=robot.window(), area=robot.area(), region=robot.region()):
        bpy.ops.dimple.calibrate("INVOKE_DEFAULT", True, filepath=str(path))  # as a click does: one step of undo
    found = record()
    yield from robot.redrawn(6)
    corner = robot.region("HUD")
    yield from robot.click(corner.x + corner.width // 2, corner.y + corner.height // 2)  # Blender shows its title alone
    yield from robot.redrawn(6)
    robot.screenshot(out / "9-touch-found.png")
    corner = robot.region("HUD")
    x, top = corner.x + corner.width * 3 // 4, corner.y + corner.height
    for y in range(top - 36, max(top - 100, corner.y), -10):  # the touch is the first field under the title
        yield from robot.move(x, y)
        yield from robot.button(x, y, "PRESS")
        for step in range(1, 9):
            yield from robot.move(x + 5 * step, y)
        yield from robot.button(x + 40, y, "RELEASE")
        yield from robot.redrawn()
        if record()["contact"] != found["contact"]:
            break
    robot.screenshot(out / "9-touch-dragged.png")
    dragged = record()
    text = "touch {:.2f} mm, K1 {:.3f} N/mm; dragged to {:.2f} mm, K1 {:.3f} N/mm"
    text = text.format(found["contact"], found["K1"], dragged["contact"], dragged["K1"])
    check("the touch is dragged in the corner, and the fit and its chart follow", dragged["K1"] != found["K1"], text)
    with bpy.context.temp_override(window=robot.window(), area=robot.area(), region=robot.region()):
        bpy.ops.dimple.discard_calibration()


def by_hand(at: tuple[int, int], body: str, out: Path, check: Check) -> robot.Waits:
    """Paste a table of grams, fit it, give it to the material and press."""
    scene, rest = bpy.context.scene.dimple, robot.positions(body)
    for name in ("hand_table", "calibration"):  # open, and alone in a tab
        panel = getattr(bpy.types, f"DIMPLE_PT_{name}")
        places = {"bl_space_type": "VIEW_3D", "bl_region_type": "UI", "bl_category": "Hand", "bl_label": panel.bl_label}
        bpy.utils.register_class(type(f"TEST_PT_{name}", (bpy.types.Panel,), {**places, "draw": panel.draw}))
    yield from robot.show_tab("Hand")
    bpy.context.window_manager.clipboard = "mm\tg\n" + "".join(f"{x}\t{52 * x + x % 3}\n" for x in range(7))
    sheet = bpy.context.window_manager.clipboard
    for name in ("paste_table", "calibrate_by_hand"):
        place = yield from clicking.button(name)
        bpy.context.window_manager.clipboard = sheet  # looking for a button copied its command
        yield from robot.click(*place)
        yield from robot.redrawn()
        robot.screenshot(out / f"9-{name}.png")
    check("a table is pasted by a click", round(scene.hand_grams[6]) == 312, f"{scene.hand_grams[6]:.0f} g")
    robot.screenshot(out / "9-tip.png")
    yield from robot.key("RET", *place)
    yield from robot.until(lambda: scene.calibration != "", "the table is fitted", 30)
    yield from robot.redrawn()
    robot.screenshot(out / "9-fitted.png")
    with robot.inside():
        bpy.ops.dimple.apply_calibration("INVOKE_DEFAULT")
        settings = bpy.data.objects[body].active_material.dimple
        bpy.ops.dimple.poke("INVOKE_DEFAULT")
    text = f"K1 {settings.K1:.3f} N/mm for 52 g a millimetre"
    check("grams become newtons", np.isclose(settings.K1, 52 * 9.80665e-3, 0.05), text)
    yield from robot.move(*at)
    yield from robot.redrawn()
    yield from robot.button(*at, "PRESS")
    yield from robot.until(lambda: np.abs(robot.positions(body) - rest).max() > 1e-3, "the ball is pressed", 120)
    yield from robot.redrawn()
    robot.screenshot(out / "9-pressed.png")
    yield from robot.button(*at, "RELEASE")
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: not robot.modal_operators(), "Esc ends the poke", 30)
