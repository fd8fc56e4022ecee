"""The Poke tool as a brush: a circle before the first click, F and Ctrl F, the wheel, and clicks beside the body."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import robot

Check = Callable[..., None]
DRAG_PX = 40
OTHER = "Beside"


def brush(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Size, zoom and select before the first press, then the same while the poke runs."""
    settings = bpy.context.scene.dimple
    settings.press_by, settings.finger_radius_mm, settings.press_depth_mm = "DEPTH", 10.0, 15.0
    with robot.inside():
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.0, -2.2, 0.0))  # seen to the left
        bpy.context.object.name = OTHER
        select("Cube")
        bpy.ops.ed.undo_push(message="Beside")
    yield from robot.redrawn()
    yield from circle(at, out, check)
    yield from size_and_zoom(at, out, check, "before the first click")
    yield from choose(check, "before the first click")
    select("Cube")
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    yield from robot.until(lambda: pressed() > 0.01, "the fingertip is in the cube", 120)
    robot.screenshot(out / "0-brush-pressing.png")
    yield from robot.button(*at, "RELEASE")
    yield from robot.until(lambda: pressed() == 0, "it is out", 60)
    yield from circle(at, out, check)
    yield from size_and_zoom(at, out, check, "while the poke runs")
    yield from choose(check, "while the poke runs")
    check("and the poke goes on", "DIMPLE_OT_poke" in robot.modal_operators())
    yield from robot.move(*at)
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: not sessions(), "Esc ends the poke", 30)
    bpy.data.objects.remove(bpy.data.objects[OTHER])
    bpy.context.scene.dimple.press_by = "FORCE"  # as it was
    select("Cube")
    yield from robot.redrawn()


def sessions() -> dict:
    return robot.extension("operators.press.sessions").sessions


def pressed() -> float:
    """Return how deep the deepest fingertip is [m]."""
    return max((float(body.frame.depths.max(initial=0.0)) for body in sessions().values()), default=0.0)


def select(name: str) -> None:
    for each in bpy.context.view_layer.objects:
        each.select_set(each.name == name)
    bpy.context.view_layer.objects.active = bpy.data.objects[name]


def circle(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Look at the circle: it is there where the mouse is on the cube, and not beside it."""
    yield from robot.move(at[0] + 400, at[1] + 150)
    yield from robot.looks(10)
    before = robot.screenshot(out / "0-brush-beside.png")
    yield from robot.move(*at)
    yield from robot.looks(10)
    seen = robot.differing(before, robot.screenshot(out / "0-brush-circle.png"), at, robot.HALF)
    check("a circle is under the mouse before it is pressed", 40 < seen < 1500, f"{seen} pixels differ")


def size_and_zoom(at: tuple[int, int], out: Path, check: Check, when: str) -> robot.Waits:
    settings = bpy.context.scene.dimple
    for name, ctrl in (("finger_radius_mm", False), ("press_depth_mm", True)):
        first = getattr(settings, name)
        yield from drag_key(at, ctrl, "ESC")
        same = getattr(bpy.context.scene.dimple, name)
        check(f"{when}: Esc leaves {name} as it was", same == first, f"{first} and {same} mm")
        yield from drag_key(at, ctrl, "LEFTMOUSE", out / f"0-brush-{name}.png")
        now, settings = getattr(bpy.context.scene.dimple, name), bpy.context.scene.dimple
        check(f"{when}: the key F drags {name}", first < now < 10 * first, f"{first} to {now} mm")
        setattr(settings, name, first)
        yield from robot.looks(4)
    view = robot.area().spaces.active.region_3d
    far = view.view_distance
    for kind in ("WHEELUPMOUSE", "WHEELDOWNMOUSE"):
        yield from robot.move(*at)
        yield from robot.button(*at, "PRESS", kind)
        yield from robot.looks(20)
        check(f"{when}: {kind} zooms", (view.view_distance < far * 0.99) == (kind == "WHEELUPMOUSE"))
    check(f"{when}: the wheel leaves the radius", settings.finger_radius_mm == 10.0)


def drag_key(at: tuple[int, int], ctrl: bool, end: str, picture: Path | None = None) -> robot.Waits:
    """Strike F, move the mouse outward, and end that by a click or by Esc."""
    yield from robot.move(*at)
    yield from robot.looks(6)
    yield from robot.key("F", *at, ctrl=ctrl)
    to = at[0] + DRAG_PX, at[1]
    for share in (0.25, 0.5, 0.75, 1.0):
        yield from robot.move(at[0] + share * DRAG_PX, at[1])
    yield from robot.looks(6)
    if picture:
        robot.screenshot(picture)
    for value in ("PRESS", "RELEASE"):
        yield from robot.button(*to, value, end)
    yield from robot.looks(6)


def choose(check: Check, when: str) -> robot.Waits:
    """Click the other object, which is neither soft nor selected."""
    running = set(sessions())
    place = robot.on_screen(tuple(bpy.data.objects[OTHER].location))
    yield from robot.click(*place)
    yield from robot.looks(20)
    chosen = bpy.context.view_layer.objects.active
    check(f"{when}: a click beside the body selects", chosen.name == OTHER and chosen.select_get(), chosen.name)
    check(f"{when}: and presses nothing", set(sessions()) == running and not bpy.data.objects[OTHER].dimple.enabled)
