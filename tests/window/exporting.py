"""Export in the window test: the dialog with its estimate, a format clicked, exported; Blender's own dialog warns."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import robot

Check = Callable[..., None]
FRAMES = 24
FORMATS, ROW = (1190, 690), 20  # [px] on the first of the formats, and from one to the next; which is where differs
EXPORT = (1207, 43)  # [px] on the button that begins


def export(at: tuple[int, int], body: str, out: Path, check: Check) -> robot.Waits:
    """Export a body by the dialog, then bake it and look at what Blender's glTF exporter says."""
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    scene, obj = bpy.context.scene, bpy.data.objects[body]
    scene.frame_start, scene.frame_end = 1, FRAMES
    obj.dimple.simulated = "MESH"
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "exported"
        scene.dimple.cache_dir = str(Path(place) / "cache")
        folder.mkdir()
        yield from _in_dialog(at, folder, out, check)
        bpy.ops.dimple.bake(frame_start=1, frame_end=3)
        yield from _open(lambda: bpy.ops.export_scene.gltf("INVOKE_DEFAULT"))
        robot.screenshot(out / "11-gltf.png")
        warning = robot.extension("addon.still_warning")
        check("Blender's glTF dialog warns of a still", warning.stills(bpy.context, dialog()) == [body])
        yield from _close(at)
        bpy.ops.dimple.unbake()
    obj.dimple.simulated, scene.dimple.cache_dir = "AUTO", ""


def _in_dialog(at: tuple[int, int], folder: Path, out: Path, check: Check) -> robot.Waits:
    yield from _open(lambda: bpy.ops.dimple.export_animation("INVOKE_DEFAULT", formats={"PC2"}))
    robot.screenshot(out / "11-export.png")
    said = dialog()._estimate(bpy.context)[0]
    check("the export dialog says frames and size", said.startswith(f"{FRAMES} frames of "), said)
    yield from choose("GLB")
    robot.screenshot(out / "11-export-2.png")
    browser().spaces.active.params.directory = str(folder).encode()
    yield from robot.looks(20)
    yield from robot.click(*EXPORT)
    yield from robot.until(lambda: (folder / "Ball.json").exists() and not robot.modal_operators(), "it exports", 300)
    names = sorted(path.name for path in folder.iterdir())
    check("the export wrote its files and nothing else", names == [f"Ball.{e}" for e in ("csv", "glb", "json")])
    yield from robot.redrawn()


def choose(form: str) -> robot.Waits:
    """Click a format."""
    for row in range(8):
        yield from robot.click(FORMATS[0], FORMATS[1] - ROW * row)
        yield from robot.looks(4)
        if dialog().formats == {form}:
            break
    yield from robot.until(lambda: dialog().formats == {form}, "a click chooses a format", 10)


def _open(ask: Callable[[], object]) -> robot.Waits:
    with robot.inside():
        ask()
    yield from robot.until(lambda: browser() is not None, "the file browser opens", 60)
    yield from robot.looks(20)


def browser() -> bpy.types.Area | None:
    return next((area for area in robot.window().screen.areas if area.type == "FILE_BROWSER"), None)


def dialog() -> bpy.types.Operator:
    return browser().spaces.active.active_operator


def _close(at: tuple[int, int]) -> robot.Waits:
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: browser() is None, "ESC closes the file browser", 30)
    yield from robot.redrawn()
