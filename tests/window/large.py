"""A large mesh in the window test: it gets ready while Blender goes on, Esc stops that, and then it is pressed."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import bpy
import robot

Check = Callable[..., None]
SUBDIVISIONS = 8  # 163,842 vertices
DENT_M = 4e-3  # that is seen
DRAWN = 3  # pictures at least while it gets ready; how far apart they are depends on what else the computer does


def press_large(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Poke a large ball: stopped by Esc, then ready and pressed; the scene is put back."""
    others = list(bpy.context.selected_objects)
    with robot.inside():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=SUBDIVISIONS, radius=1.0, location=(0.0, 0.0, 0.0))
    large = bpy.context.object
    large.dimple.size_mode = "CUSTOM"
    for other in others:
        other.hide_set(True)
    yield from robot.redrawn()
    running, runs = robot.extension("operators.press.sessions"), robot.extension("operators.press.modal_runs").runs
    _poke()
    yield from robot.looks(3)
    check("a large mesh gets ready while Blender goes on", [run.kind for run in runs] == ["work"])
    robot.screenshot(out / "0-getting-ready.png")
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: not runs, "Esc stops it", 60)
    check("Esc stops it and nothing is left", not running.sessions and not large.modifiers)
    _poke()
    robot.watch()
    begun, drawn = time.monotonic(), robot.drawn()
    while not any(run.kind == "poke" for run in runs):
        yield robot.TICK_S
        robot.area().tag_redraw()
    ready, age, drawn = time.monotonic() - begun, robot.oldest(), robot.drawn() - drawn
    words = f"{len(large.data.vertices):,} vertices, ready in {ready:.1f} s, {drawn} draws meanwhile, {age:.1f} s apart"
    check("the window is drawn meanwhile", drawn >= DRAWN, words)
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    body = running.get(large)
    yield from robot.until(lambda: body.frame.depths.any() and body.frame.depths[0] > DENT_M, "it is pressed", 200)
    yield from robot.redrawn()
    robot.screenshot(out / "0-large.png")
    yield from robot.button(*at, "RELEASE")
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: not running.sessions, "ESC ends the poke", 60)
    bpy.data.meshes.remove(large.data)
    for other in others:
        other.hide_set(False)
        other.select_set(True)
        bpy.context.view_layer.objects.active = other
    yield from robot.redrawn()


def _poke() -> None:
    with robot.inside():
        bpy.ops.dimple.poke("INVOKE_DEFAULT")
