"""Compare Proxies in the window test: stopped by ESC, then run to its end, its chart seen, one proxy chosen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import robot

Check = Callable[..., None]


def compare_proxies(at: tuple[int, int], body: str, out: Path, check: Check) -> robot.Waits:
    """Compare proxies of the body, look at the chart, choose a proxy and undo that."""
    settings, shown = bpy.data.objects[body].dimple, bpy.context.window_manager.dimple
    yield from robot.move(*at)
    yield from robot.redrawn()
    bare = robot.screenshot(out / "9-compared.png")
    start()
    check("the comparison runs", "DIMPLE_OT_compare_proxies" in robot.modal_operators())
    yield from robot.looks(2)
    yield from robot.key("ESC", *at)
    yield from robot.until(lambda: not robot.modal_operators(), "ESC stops the comparison", 30)
    check("ESC stops the comparison and nothing is kept", settings.comparison == "" and not shown.show_comparison)
    start()
    yield from robot.until(lambda: settings.comparison != "", "the comparison ends", 300)
    yield from robot.redrawn()
    charts, scale, view = (
        robot.extension("addon.comparison_chart"),
        bpy.context.preferences.system.ui_scale,
        robot.region(),
    )
    left, bottom = charts.chart_corner(robot.free_room(), scale)
    chart = round(view.x + left + charts.SIZE[0] * scale / 2), round(view.y + bottom + charts.SIZE[1] * scale / 2)
    gap = robot.differing(bare, robot.screenshot(out / "9-compared.png"), chart, robot.HALF)
    found = charts.load(settings)
    variants = ", ".join(str(each["vertices"]) for each in found)
    check("the chart of this very object is seen in the viewport", gap > robot.SEEN, f"{gap} pixels differ; {variants}")
    smallest = next(each["asked"] for each in found if each["asked"])
    bpy.ops.dimple.apply_proxy(vertices=smallest)
    check("a proxy is chosen", (settings.simulated, settings.proxy_vertices) == ("PROXY", smallest))
    settings.simulated, shown.show_comparison = "AUTO", False
    yield from robot.redrawn()


def start() -> None:
    with bpy.context.temp_override(window=robot.window(), area=robot.area(), region=robot.region()):
        bpy.ops.dimple.compare_proxies("INVOKE_DEFAULT", presses=1)
