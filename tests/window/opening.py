"""What an artist meets first: a sample and its first press, the keys in the status bar, fields, menus, Make Soft."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator
from pathlib import Path

import bpy
import clicking
import numpy as np
import robot
from mathutils import Vector

Check = Callable[..., None]
SAMPLES = "suzanne", "three_objects"
STATUS = 20  # [px] of the status bar
OTHER = "Animation"  # a workspace in Object Mode too
ALIKE = 30  # [px] of it that may differ between two pictures of the same text
EDIT = 62, 790  # [px] where the Edit menu is, with the default theme and scale
BELOW = 60  # [px] under a body, where nothing is drawn


def open_samples(out: Path, check: Check) -> robot.Waits:
    """Open the samples as an artist does and press each at once; then go back to the default scene."""
    for name in SAMPLES:
        yield from open_sample(name, out, check)
    yield from new_file()
    bpy.data.objects["Cube"].data.materials.clear()  # else it keeps its own, which was measured nowhere
    with robot.inside():
        bpy.ops.dimple.make_soft()
    yield from robot.redrawn()
    yield from status_bar(out, check)
    yield from fields(out, check)
    yield from menus(out, check)
    yield from new_file()


def new_file() -> robot.Waits:
    """Go back to the default scene and look at its cube from nearer."""
    with bpy.context.temp_override(window=robot.window()):
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield from robot.redrawn()
    view = robot.area().spaces.active
    view.region_3d.view_distance, view.show_region_toolbar = 6.0, True
    yield from robot.redrawn()


def body() -> object:
    return next(iter(robot.extension("operators.press.sessions").sessions.values()), None)


def leave(at: tuple[int, int]) -> robot.Waits:
    yield from robot.button(*at, "RELEASE")
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: body() is None, "ESC ends the poke", 60)


def open_sample(name: str, out: Path, check: Check) -> robot.Waits:
    """Open a file with its own layout: framed, with the tool, pressed by the first drag."""
    with bpy.context.temp_override(window=robot.window()):
        bpy.ops.wm.open_mainfile(filepath=f"/mnt/samples/{name}.blend", load_ui=True)
    yield from robot.redrawn(3)
    pictures = [robot.screenshot(out / f"00-{name}.png")]
    pressed, view = bpy.context.object, robot.region()
    corners = np.array([robot.on_screen(pressed.matrix_world @ Vector(each)) for each in pressed.bound_box])
    low, high = corners.min(axis=0) - (view.x, view.y), corners.max(axis=0) - (view.x, view.y)
    inside = bool((low > 0).all() and (high < (view.width, view.height)).all())
    size = float((high - low).max() / min(view.width, view.height))
    check(f"{name} opens framed", inside and size > 0.2, f"{pressed.name} takes {size:.0%} of the viewport")
    tool = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT")
    check(f"{name} opens with the poke as its tool", tool is not None and tool.idname == "dimple.poke_tool")
    at = tuple(round(each) for each in corners.mean(axis=0))
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    yield from robot.move(at[0] + 12, at[1] + 6)
    yield from robot.until(lambda: body() is not None and body().frame.depths.any(), "the first drag presses", 120)
    yield from robot.until(lambda: float(body().frame.depths[0]) > 0.003, "it dents", 200)
    yield from robot.redrawn()
    pictures.append(robot.screenshot(out / f"00-{name}-pressed.png"))
    below = round((low[0] + high[0]) / 2 + view.x), round(low[1] + view.y) - BELOW
    stray = robot.differing(*pictures, below, BELOW - 10)
    check(f"{name} is drawn nowhere but where it is", stray < ALIKE, f"{stray} pixels below it differ")
    depth, force = 1e3 * float(body().frame.depths[0]), float(np.linalg.norm(body().frame.finger_forces[0]))
    check(f"{name} is pressed by one drag", depth > 0, f"{depth:.1f} mm, {force:.1f} N")
    yield from leave(at)


def status(path: Path) -> robot.Differs:
    """Return the pixels of the status bar, with the mouse where its text is that of the window."""
    yield from robot.redrawn(3)
    return robot.screenshot(path)[-STATUS:, :900].astype(int)


def differ(one: np.ndarray, other: np.ndarray) -> int:
    return int((np.abs(one - other).max(axis=2) > 40).sum())


def status_bar(out: Path, check: Check) -> Generator[float, None, None]:
    """Poke; go to another workspace and back, undo by the menu, pause, leave: the keys are shown while they work."""
    settings, at = bpy.context.scene.dimple, robot.on_screen((0.0, 0.0, 1.0))
    settings.finger_radius_mm = 12.0
    bpy.ops.ed.undo_push(message="Radius")
    yield from robot.move(*at)
    before = yield from status(out / "00-status-before.png")
    with robot.inside():
        bpy.ops.dimple.poke("INVOKE_DEFAULT")
    yield from robot.until(lambda: body() is not None, "the poke runs", 60)
    keys = yield from status(out / "00-status-keys.png")
    check("the status bar shows the keys of the poke", differ(before, keys) > 300, f"{differ(before, keys)} pixels")
    home = robot.window().workspace
    robot.window().workspace = bpy.data.workspaces[OTHER]
    yield from robot.looks(10)
    there = yield from status(out / "00-status-workspace.png")
    running = body() is not None
    check("and in another workspace", running and differ(there, keys) < ALIKE, f"{differ(there, keys)} pixels differ")
    robot.window().workspace = home
    yield from robot.looks(10)
    settings.finger_radius_mm = 14.0
    bpy.ops.ed.undo_push(message="Radius")
    yield from robot.click(*EDIT)
    yield from robot.looks(10)
    robot.screenshot(out / "00-edit-menu.png")
    yield from robot.click(EDIT[0] + 20, EDIT[1] - 24)  # Undo is the first in it
    yield from robot.until(
        lambda: abs(bpy.context.scene.dimple.finger_radius_mm - 12) < 0.1, "Edit > Undo takes it back", 60
    )
    yield from robot.move(*at)
    yield from robot.looks(10)
    after = yield from status(out / "00-status-undone.png")
    check("and after Edit > Undo", body() is not None and differ(after, keys) < ALIKE, f"{differ(after, keys)} differ")
    (run,) = robot.extension("operators.press.modal_runs").runs
    yield from robot.key("SPACE", *at)
    yield from robot.until(lambda: run.paused, "it is paused", 60)
    yield from robot.redrawn(3)
    robot.screenshot(out / "00-paused.png")
    yield from robot.key("SPACE", *at)
    yield from robot.until(lambda: not run.paused, "it goes on", 60)
    robot.window().workspace = bpy.data.workspaces[OTHER]
    yield from robot.looks(10)
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: body() is None, "ESC ends the poke in the other workspace", 60)
    there = yield from status(out / "00-status-left-there.png")
    robot.window().workspace = home
    yield from robot.looks(10)
    here = yield from status(out / "00-status-left.png")
    gone = f"{differ(there, keys)} and {differ(here, keys)} pixels differ"
    check("and the keys are gone from both when it has ended", min(differ(there, keys), differ(here, keys)) > 300, gone)


def fields(out: Path, check: Check) -> robot.Waits:
    """Edit the first constant of a measured material: no field may move away under the mouse."""
    area = robot.area()
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"  # it has no material panels and no slow preview
    area.type = "PROPERTIES"
    area.spaces.active.context = "MATERIAL"
    yield from robot.looks(30)
    region = next(each for each in area.regions if each.type == "WINDOW")
    before = yield from clicking.fields(area, region)
    robot.screenshot(out / "00-fields.png")
    material = bpy.data.objects["Cube"].active_material.dimple
    material.K1 = 2 * material.K1
    check("a measured material is marked as edited", material.edited)
    yield from robot.looks(30)
    after = yield from clicking.fields(area, region)
    robot.screenshot(out / "00-fields-edited.png")
    moved = [name for name in before if after.get(name) != before[name]]
    check("no field moves at the first edit", len(before) >= 8 and not moved, f"{sorted(before)}; moved: {moved}")
    area.type = "VIEW_3D"
    yield from robot.redrawn()


def menus(out: Path, check: Check) -> robot.Waits:
    """Look at the menu, the sidebar and the panels, in Japanese too, and at what is reported there."""
    at, view = robot.on_screen((0.0, 0.0, 1.0)), bpy.context.preferences.view
    yield from robot.move(*at)
    yield from robot.show_tab("Dimple")
    for language in ("en_US", "ja_JP"):
        view.language = language
        yield from robot.redrawn(3)
        with robot.inside():
            bpy.ops.wm.call_menu(name="DIMPLE_MT_object")
        yield from robot.looks(15)
        robot.screenshot(out / f"00-menu-{language[:2]}.png")
        yield from robot.key("ESC", *at)
    yield from panels(out)
    with robot.inside():
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(0.0, 0.0, 3.0))
        bpy.ops.wm.call_menu(name="DIMPLE_MT_object")
    yield from robot.looks(15)
    yield from robot.key("RET", *at)  # Make Soft is the first
    yield from robot.looks(15)
    robot.screenshot(out / "00-japanese-question.png")
    yield from robot.key("RET", *at)  # cut it finer
    yield from robot.until(lambda: bpy.context.object.dimple.enabled, "the sphere is soft", 60)
    yield from robot.redrawn()
    robot.screenshot(out / "00-japanese-report.png")
    reports = [each.message for each in bpy.context.window_manager.reports]
    said = next((each for each in reversed(reports) if "mm" in each), "")
    words = re.findall("[A-Za-z]{3,}", re.sub('"[^"]*"', "", said))  # names stand in quotes
    check("a report with numbers is in Japanese", not words and bool(re.search("[ぁ-ん]", said)), said)
    view.language = "en_US"
    yield from robot.redrawn()


def panels(out: Path) -> robot.Waits:
    """Photograph the panels of the properties editor in the room of the viewport."""
    area = robot.area()
    area.type = "PROPERTIES"
    for tab in ("MATERIAL", "PHYSICS"):
        area.spaces.active.context = tab
        yield from robot.looks(30)
        robot.screenshot(out / f"00-japanese-{tab.lower()}.png")
    area.type = "VIEW_3D"
    yield from robot.redrawn()
