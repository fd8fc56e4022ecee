"""Compare Methods in the window test: stopped by ESC, then to its end, its chart seen, one way taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import robot

Check = Callable[..., None]


def compare_methods(at: tuple[int, int], body: str, out: Path, check: Check) -> robot.Waits:
    """Compare ways to simulate the body, look at the chart, take a stand-in and give it back."""
    settings, shown = bpy.data.objects[body].dimple, bpy.context.window_manager.dimple
    yield from robot.move(*at)
    yield from robot.redrawn()
    bare = robot.screenshot(out / "9-compared.png")
    start()
    check("the comparison runs", "DIMPLE_OT_compare_methods" in robot.modal_operators())
    yield 0.5
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: not robot.modal_operators(), "ESC stops the comparison", 30)
    check("ESC stops the comparison and nothing is kept", settings.comparison == "" and not shown.show_comparison)
    start()
    yield from robot.until(lambda: settings.comparison != "", "the comparison ends", 300)
    yield from robot.redrawn()
    methods, scale, view = robot.extension("addon.methods"), bpy.context.preferences.system.ui_scale, robot.region()
    left, bottom = methods.chart_corner(robot.area(), view, scale)
    chart = round(view.x + left + methods.SIZE[0] * scale / 2), round(view.y + bottom + methods.SIZE[1] * scale / 2)
    gap = robot.differing(bare, robot.screenshot(out / "9-compared.png"), chart, robot.HALF)
    found = methods.load(settings)
    variants = ", ".join(str(each["vertices"]) for each in found)
    check("the chart of this very object is seen in the viewport", gap > robot.SEEN, f"{gap} pixels differ; {variants}")
    smallest = next(each["asked"] for each in found if each["asked"])
    bpy.ops.dimple.apply_method(vertices=smallest)
    check("a way is taken", (settings.moves, settings.stand_in_vertices) == ("STAND_IN", smallest))
    settings.moves, shown.show_comparison = "AUTO", False
    yield from robot.redrawn()


def start() -> None:
    with bpy.context.temp_override(window=robot.window(), area=robot.area(), region=robot.region()):
        bpy.ops.dimple.compare_methods("INVOKE_DEFAULT", presses=1)
