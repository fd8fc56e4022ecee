"""A fingertip animated with the mouse: added, keyed, dragged by its gizmo, clicked with the tool."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import clicking
import numpy as np
import robot

Check = Callable[..., None]
Place = tuple[int, int]
LAST = 12  # frame


def animate(at: Place, body: str, out: Path, check: Check) -> robot.Waits:
    """Add a fingertip, key it twice with its arrow dragged between, bake; then click it with the tool."""
    scene, obj = bpy.context.scene, bpy.data.objects[body]
    scene.frame_set(1)  # an earlier scene may have played
    scene.frame_end, scene.dimple.cache_dir, obj.dimple.enabled = LAST, "/tmp", True
    yield from clicking.search("Add Fingertip", at)
    yield from robot.until(lambda: scene.dimple.finger_1 is not None, "there is a fingertip", 20)
    name = scene.dimple.finger_1.name
    yield from robot.move(*at)
    yield from robot.redrawn()
    robot.screenshot(out / "12-gizmo.png")
    check("the fingertip alone is selected", [each.name for each in bpy.context.selected_objects] == [name])
    yield from key_and_jump(at, LAST)
    yield from drag_arrow(name, check)
    robot.screenshot(out / "12-dragged.png")
    yield from clicking.strike("I", at)
    yield from robot.looks(6)
    check("I keys it at both frames", keyed(name) == [1, LAST], f"{keyed(name)}")
    yield from drag_circle(name, at, out, check)
    yield from clicking.search("Bake", at)
    yield from robot.until(lambda: "Dimple" in obj.modifiers, "it is baked", 400)
    check("Bake with the fingertip active bakes what it presses", True)
    dented = robot.positions(body)[:, 2].max()
    check("and it is dented", dented < 0.95, f"{dented:.3f} m high")
    yield from robot.redrawn()
    robot.screenshot(out / "12-baked.png")
    yield from click_with_tool(name, out, check)


def keyed(name: str) -> list[int]:
    """Return the frames at which an object's height is keyed."""
    animation = bpy.data.objects[name].animation_data
    if animation is None or animation.action is None:
        return []
    curves = [curve for layer in animation.action.layers for strip in layer.strips for bag in strip.channelbags
              for curve in bag.fcurves if (curve.data_path, curve.array_index) == ("location", 2)]  # fmt: skip
    return [round(point.co[0]) for curve in curves for point in curve.keyframe_points]


def key_and_jump(at: Place, frame: int) -> robot.Waits:
    """Strike I over the viewport, then Shift Right for the last frame."""
    yield from clicking.strike("I", at)
    yield from robot.looks(6)
    yield from clicking.strike("RIGHT_ARROW", at, shift=True)
    yield from robot.until(lambda: bpy.context.scene.frame_current == frame, "a key leads to the last frame", 10)
    yield from robot.redrawn()


def pull(start: Place, end: Place) -> robot.Waits:
    """Drag with the left mouse button."""
    yield from robot.move(*start)
    yield from robot.redrawn()
    yield from robot.move(start[0] + 1, start[1])
    yield from robot.redrawn()
    yield from robot.button(*start, "PRESS")
    for share in (0.2, 0.4, 0.6, 0.8, 1.0):
        yield from robot.move(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))
    yield from robot.redrawn()
    yield from robot.button(*end, "RELEASE")
    yield from robot.redrawn()


def of(name: str) -> tuple[np.ndarray, float]:
    """Return place and radius of a fingertip."""
    tip = bpy.data.objects[name]
    bpy.context.view_layer.update()
    return np.array(tip.matrix_world.translation), tip.empty_display_size * tip.matrix_world.median_scale


def drag_arrow(name: str, check: Check) -> robot.Waits:
    """Drag the arrow of the gizmo towards the body."""
    place, radius = of(name)
    tail = robot.on_screen(tuple(place + (0, 0, radius)))
    head = tail[0], tail[1] + 40
    yield from pull(head, (head[0], head[1] - 45))
    moved = of(name)[0] - place
    check("its arrow moves it along its press alone", moved[2] < -0.05 and np.abs(moved[:2]).max() < 1e-5, f"{moved}")


def drag_circle(name: str, at: Place, out: Path, check: Check) -> robot.Waits:
    """Drag the circle outwards and undo that."""
    place, radius = of(name)
    turn = np.array(robot.area().spaces.active.region_3d.view_matrix)[:3, :3]
    edge, beyond = (robot.on_screen(tuple(place + share * radius * turn[0])) for share in (1.0, 1.5))
    yield from pull(edge, beyond)
    robot.screenshot(out / "12-circle.png")
    check("its circle changes its radius", of(name)[1] > 1.2 * radius, f"{radius:.3f} to {of(name)[1]:.3f} m")
    yield from robot.key("Z", *at, ctrl=True)
    yield from robot.until(lambda: abs(of(name)[1] - radius) < 1e-4, "Ctrl-Z takes it back", 20)


def click_with_tool(name: str, out: Path, check: Check) -> robot.Waits:
    """Click the fingertip with the Poke tool: it is selected, and nothing is pressed."""
    with robot.inside():
        bpy.ops.wm.tool_set_by_id(name="dimple.poke_tool")
        bpy.ops.object.select_all(action="DESELECT")
    bpy.context.scene.frame_set(1)
    yield from robot.redrawn()
    yield from robot.click(*robot.on_screen(tuple(of(name)[0])))
    yield from robot.redrawn()
    robot.screenshot(out / "12-clicked.png")
    chosen = [each.name for each in bpy.context.selected_objects]
    check("a click with the Poke tool selects it", chosen == [name] and not robot.modal_operators(), f"{chosen}")
