"""The models that artists have, each pressed by clicks and keys, kept, and rendered in all three engines."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import bmesh
import bpy
import clicking
import numpy as np
import opening
import robot

Check = Callable[..., None]
Place = tuple[int, int]
ENGINES = "BLENDER_WORKBENCH", "BLENDER_EEVEE", "CYCLES"
SIZE = 640, 400  # [px] of a render
HELD_MM = 8.0  # that a press is waited for


def cube() -> tuple[float, float, float]:
    """Leave the default cube as it is; return where it is pressed."""
    return 0.3, -0.3, 1.0


def sphere() -> tuple[float, float, float]:
    """Add the default UV sphere."""
    _fresh(bpy.ops.mesh.primitive_uv_sphere_add)
    return 0.45, -0.55, 0.7


def suzanne() -> tuple[float, float, float]:
    """Add Suzanne with a Subdivision of level 2."""
    head = _fresh(bpy.ops.mesh.primitive_monkey_add)
    head.rotation_euler.z = 0.6
    _subdivide(head, 2, 2)
    return 0.3, -0.45, 0.75


def shell() -> tuple[float, float, float]:
    """Add half a sphere that is mirrored and made solid."""
    half = _fresh(lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24))
    mesh = bmesh.new()
    mesh.from_mesh(half.data)
    bmesh.ops.delete(mesh, geom=[each for each in mesh.verts if each.co.x < -1e-4], context="VERTS")
    mesh.to_mesh(half.data)
    mesh.free()
    half.modifiers.new("Mirror", "MIRROR").use_clip = True
    half.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.25
    return 0.45, -0.55, 0.7


def character() -> tuple[float, float, float]:
    """Add a limb of two bones, subdivided after its armature, in a render finer than in the viewport."""
    limb = _fresh(lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16, scale=(0.7, 0.7, 1.1)))
    bpy.ops.object.armature_add(location=(0.0, 0.0, -1.0))
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    upper = rig.data.edit_bones.new("Upper")
    upper.parent, upper.head, upper.tail = rig.data.edit_bones[0], (0.0, 0.0, 1.0), (0.0, 0.0, 2.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    limb.select_set(True)
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    rig.pose.bones[1].rotation_mode = "XYZ"
    rig.pose.bones[1].rotation_euler.x = -0.4
    rig.select_set(False)
    bpy.context.view_layer.objects.active = limb
    _subdivide(limb, 1, 3)
    return 0.25, -0.5, 0.2


MODELS = {each.__name__: each for each in (cube, sphere, suzanne, shell, character)}


def _fresh(add: Callable[[], object]) -> bpy.types.Object:
    """Put a smooth object in the place of the default cube."""
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    add()
    bpy.ops.object.shade_smooth()
    return bpy.context.object


def _subdivide(obj: bpy.types.Object, shown: int, rendered: int) -> None:
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = shown, rendered


def model(name: str, out: Path, check: Check) -> robot.Waits:
    """Press a model by four actions of the hand, keep the dent by Enter, and render it."""
    yield from opening.new_file()
    with robot.inside():
        at = robot.on_screen(MODELS[name]())
        bpy.ops.view3d.camera_to_view()
    robot.area().spaces.active.region_3d.view_perspective = "PERSP"
    body = bpy.context.object
    mesh = np.array([vertex.co for vertex in body.data.vertices])
    yield from robot.redrawn()
    plain = {engine: render(engine, out / f"m-{name}-{engine.lower()}-plain.png") for engine in ENGINES}
    rest = robot.screenshot(out / f"m-{name}-1-rest.png")
    yield from press(at, rest, name, out, check)
    yield from robot.key("RET", *at)
    yield from robot.until(lambda: opening.body() is None, "Enter keeps the dent", 60)
    yield from robot.redrawn()
    kept = robot.screenshot(out / f"m-{name}-3-kept.png")
    seen = robot.differing(rest, kept, at, robot.HALF)
    check(f"{name}: the kept dent is seen", seen > robot.SEEN, f"{seen} pixels differ")
    same = np.array_equal(mesh, [vertex.co for vertex in bpy.context.object.data.vertices])
    check(f"{name}: its own mesh is the same bit for bit", same and "Pressed" in bpy.context.object.modifiers)
    for engine in ENGINES:
        picture = render(engine, out / f"m-{name}-{engine.lower()}.png")
        changed = int((np.abs(picture - plain[engine]).max(axis=2) > 6 / 255).sum())
        check(f"{name}: {engine} renders the dent", changed > robot.SEEN / 4, f"{changed} pixels differ")


def press(at: Place, rest: np.ndarray, name: str, out: Path, check: Check) -> robot.Waits:
    """Open the tab, click Make Soft, drag: the dent is seen."""
    yield from clicking.open_tab("Dimple", at)
    yield from robot.click(*(yield from clicking.button("make_soft")))
    yield from robot.until(lambda: bpy.context.object.dimple.enabled, "it is soft", 60)
    robot.area().spaces.active.show_region_ui = False
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    yield from robot.until(lambda: depth_mm() > HELD_MM, f"it is pressed {HELD_MM} mm deep", 300)
    yield from robot.looks(40)
    yield from robot.redrawn()
    pressed = robot.screenshot(out / f"m-{name}-2-pressed.png")
    seen = robot.differing(rest, pressed, at, robot.HALF)
    check(f"{name}: the press is seen", seen > robot.SEEN, f"{depth_mm():.1f} mm, {seen} pixels differ")


def depth_mm() -> float:
    body = opening.body()
    return 1e3 * float(body.frame.depths.max(initial=0.0)) if body else 0.0


def render(engine: str, path: Path) -> np.ndarray:
    """Render the scene small, and return the picture (rows, columns, 4) of 0..1."""
    scene, began = bpy.context.scene, time.monotonic()
    scene.render.engine, scene.render.filepath = engine, str(path)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE, 100
    scene.cycles.samples = scene.eevee.taa_render_samples = 16
    bpy.ops.render.render(write_still=True)
    scene.render.engine = "BLENDER_WORKBENCH"
    picture = bpy.data.images.load(str(path))
    pixels = np.empty(4 * SIZE[0] * SIZE[1], np.float32)
    picture.pixels.foreach_get(pixels)
    bpy.data.images.remove(picture)
    print(f"{engine}: {time.monotonic() - began:.1f} s", flush=True)
    return pixels.reshape(SIZE[1], SIZE[0], 4)
