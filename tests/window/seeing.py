"""What is seen while one tunes: colours; x0 painted; two materials; a weight."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import clicking
import device
import numpy as np
import opening
import robot
import tuning
from mathutils import Euler, Vector

Check = Callable[..., None]
FORCE_N, PAINTED = 15.0, 0.375  # past the knee, which is painted to be three quarters as deep
LOOP, SWELL_S = 20, 2.4  # pictures of it, and how long it takes in simulated time [s]
DEEPEST = 0.25  # of the side of a cube: how deep the press of two is
ROOM = Vector((0.35, 0.0, 0.0))  # [m] to the left of the two cubes, for their charts


def as_measured() -> None:
    """Give the cube the constants that it was measured with, and nothing painted, and the fingertip its force."""
    cube = bpy.data.objects["Cube"]
    cube.dimple.softness_group = cube.dimple.knee_group = ""
    cube.active_material.dimple.K1, bpy.context.scene.dimple.press_force_n = 0.61, FORCE_N
    bpy.ops.ed.undo_push(message="As measured")


def show(name: str) -> robot.Waits:
    """Choose by the wheel over its field what is shown in colours."""
    device.open_panel("DIMPLE_PT_display", "Dimple")  # open, and the last
    yield from clicking.choose("show_field", lambda: bpy.context.scene.dimple.show_field == name)


def colours(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Show each quantity on the pressed surface."""
    as_measured()
    settings = bpy.context.scene.dimple
    yield from tuning.leave_resting(at)
    yield from tuning.settle("it rests")
    device.open_panel("DIMPLE_PT_display", "Dimple")
    yield from clicking.open_tab("Dimple", at)
    yield from clicking.open_last_panel("show_field")
    yield from robot.redrawn()
    plain = robot.screenshot(out / "0-plain.png")
    for name in ("PRESSURE", "DEPTH", "STRETCH"):
        yield from show(name)
        yield from robot.redrawn(3)
        coloured = robot.screenshot(out / f"0-colours-{name.lower()}.png")
        gap = robot.differing(plain, coloured, at, robot.HALF)
        check(f"{name.lower()} is seen in colours", gap > robot.SEEN, f"{gap} pixels differ")
        if name == "DEPTH":  # a hole in the colours is grey
            side = robot.on_screen((1.0, 0.0, 0.0))
            face = coloured[robot.HEIGHT - side[1] - 60 : robot.HEIGHT - side[1] + 60, side[0] - 60 : side[0] + 60]
            share = float((np.ptp(face.astype(int), axis=2) > 30).mean())
            check("the colours cover the surface without holes", share > 0.95, f"{share:.0%}")
            corner = robot.on_screen((-1.0, -1.0, 2.0))
            row, column = robot.HEIGHT - corner[1], corner[0]
            beside = coloured[row - 20 : row + 20, column - 20 : column + 20]
            check("and nothing beside it", int(np.ptp(beside.astype(int), axis=2).max()) < 120)
    robot.area().spaces.active.overlay.show_overlays = False
    yield from robot.redrawn(3)
    bare = robot.screenshot(out / "0-no-overlays.png")
    grey = np.ptp(bare[200:600, 400:700].astype(int), axis=2).max()
    check("without overlays nothing of it is left", grey < 40, f"{grey} of 255 from grey at most")
    robot.area().spaces.active.overlay.show_overlays = True
    settings.show_field = "NONE"
    yield from tuning.leave(at)


def paint_knee(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Paint x0 with a brush while a force rests: the press stops there."""
    as_measured()
    cube = tuning.finer()
    cube.vertex_groups.new(name="Reach").add(range(len(cube.data.vertices)), 0.5, "REPLACE")
    cube.dimple.knee_group = "Reach"
    yield from tuning.leave_resting(at)
    yield from tuning.settle("it rests")
    yield from clicking.mode("W", "PAINT_WEIGHT")
    yield from clicking.brush(PAINTED, 100)
    robot.screenshot(out / "0-brush.png")
    for _ in range(3):
        yield from robot.move(at[0] + 60, at[1])
        yield from robot.button(at[0] + 60, at[1], "PRESS")
        for share in range(16):
            yield from robot.move(at[0] + 60 - 8 * share, at[1] + 12 * (share % 3 - 1))
        yield from robot.button(at[0] - 60, at[1], "RELEASE")
    yield from robot.looks(20)
    yield from tuning.settle("it rests again")
    material = cube.active_material.dimple
    x0 = 2 * PAINTED * material.x0
    wanted = x0 + (FORCE_N - material.K1 * x0) / material.K2
    depth = 1e3 * float(opening.body().frame.depths[0])
    words = f"{depth:.2f} mm for {wanted:.2f} mm, {100 * (depth / wanted - 1):+.1f} %"
    check("the press stops within 5 % of where x0 is painted", abs(depth / wanted - 1) < 0.05, words)
    yield from robot.redrawn(3)
    robot.screenshot(out / "0-painted-knee.png")
    yield from clicking.mode("O", "OBJECT")
    yield from tuning.leave(at)


def two_materials(at: tuple[int, int], out: Path, check: Check) -> robot.Waits:
    """Press two materials side by side by as much."""
    as_measured()
    settings, view, cube = bpy.context.scene.dimple, robot.area().spaces.active.region_3d, bpy.data.objects["Cube"]
    bpy.ops.ed.undo_push(message="Before the second cube")
    round_edges = cube.modifiers.new("Bevel", "BEVEL")
    round_edges.width, round_edges.segments = 0.4, 6
    cube.data.shade_smooth()
    other = cube.copy()
    other.name, other.data = "Cube B", cube.data.copy()
    other.active_material = cube.active_material.copy()
    bpy.context.collection.objects.link(other)
    other.location.x += 2.5
    other.active_material.dimple.K1, other.active_material.dimple.x0 = 1.83, 5.0
    before = view.view_distance, view.view_location.copy(), view.view_rotation.copy()
    view.view_distance = 6.9
    view.view_rotation = Euler((0.8, 0.0, 0.0)).to_quaternion()  # side by side, seen from above
    view.view_location = 0.5 * other.matrix_world.translation - view.view_rotation @ ROOM
    settings.show_field = "DEPTH"
    robot.area().spaces.active.show_region_ui = False  # both are seen whole
    tips = []
    for each in (cube, other):
        with bpy.context.temp_override(window=robot.window(), area=robot.area(), object=each, active_object=each):
            bpy.ops.dimple.add_fingertip()
        tips.append(bpy.context.object)
    for each in (cube, other):
        each.select_set(True)
    with robot.inside():
        bpy.ops.dimple.play("INVOKE_DEFAULT")
    yield from robot.until(lambda: opening.body() is not None and opening.body().frame.time > 0, "both play", 60)
    bodies = robot.extension("operators.press.sessions").sessions
    readout = robot.extension("addon.readout")
    rate, readout.rate_hz = readout.rate_hz, lambda _frame: 0.0  # how slow this machine is belongs in no picture
    for each in (cube, other, *tips):
        each.select_set(False)
    yield from robot.move(200, 120)  # off the bodies
    up = tips[0].location.z
    for number in range(LOOP):  # `run.py` makes a looping picture of it
        for tip in tips:
            tip.location.z = up - DEEPEST * (0.5 - 0.5 * np.cos(2 * np.pi * number / LOOP))
        begun = opening.body().frame.time
        yield from robot.until(lambda begun=begun: opening.body().frame.time > begun + SWELL_S / LOOP, "it goes on", 60)
        yield from robot.redrawn(1)
        robot.screenshot(out / f"loop-{number:02}.png")
        if number == LOOP // 2:
            forces = {body.name: float(max(body.frame.pushes)) for body in bodies.values()}
    shown = ", ".join(f"{name} {force:.2f} N" for name, force in forces.items())
    check("pressed as deep, the softer one gives less force", forces["Cube B"] > 1.5 * forces["Cube"] > 0, shown)
    readout.rate_hz = rate
    yield from tuning.leave(at)
    settings.show_field = "NONE"
    view.view_distance, view.view_location, view.view_rotation = before
    robot.area().spaces.active.show_region_ui = True
    for each in (other, *tips):
        bpy.data.objects.remove(each)
    yield from robot.redrawn()
