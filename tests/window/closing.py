"""A press that is begun in a second window, in the window test: that window is closed, and Blender goes on."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import robot

Check = Callable[..., None]


def close(check: Check) -> robot.Waits:
    """Poke and play the default cube in a window of their own, and close that."""
    running = robot.extension("operators.press.sessions")
    runs = robot.extension("operators.press.modal_runs").runs
    cube = bpy.data.objects["Cube"]
    for name in ("poke", "play"):
        with bpy.context.temp_override(window=robot.window()):
            bpy.ops.wm.window_new()
        yield from robot.looks(20)
        second = bpy.context.window_manager.windows[-1]
        area = max(second.screen.areas, key=lambda each: (each.type == "VIEW_3D", each.width * each.height))
        region = next(each for each in area.regions if each.type == "WINDOW")
        with bpy.context.temp_override(
            window=second, area=area, region=region, object=cube, active_object=cube, selected_objects=[cube]
        ):
            getattr(bpy.ops.dimple, name)("INVOKE_DEFAULT")
        yield from robot.looks(20)
        check(f"{name} runs in a second window", bool(running.sessions and runs and second.modal_operators))
        with bpy.context.temp_override(window=second):
            bpy.ops.wm.window_close()
        yield from robot.looks(20)
        check(f"once its window is closed, {name} has ended", not running.sessions and not runs)
        check("the object is as it was", not cube.modifiers)
        yield from robot.redrawn()
