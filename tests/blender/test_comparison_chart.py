"""The chart of a comparison shows every variant at its cost and its error."""

import json
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.test_overlay import SCREEN, on_screen, viewport

NAMES = ("asked", "vertices", "steps", "cost", "error", "force_error")
FOUND = (
    (0, 9602, 9, 1.0, 0.0, 0.0), (200, 200, 3, 0.012, 0.85, 0.44),
    (565, 565, 5, 0.039, 0.35, 0.19), (1600, 1600, 8, 0.15, 0.13, 0.07),
)  # fmt: skip


@pytest.fixture
def body(empty_file: ModuleType) -> Any:
    bpy = empty_file
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    obj.dimple.comparison = json.dumps({"variants": [dict(zip(NAMES, row, strict=True)) for row in FOUND]})
    return obj


def test_the_chart_leaves_the_colours_of_proxies_and_the_mesh(bpy: ModuleType, body: Any) -> None:
    import gpu
    from bl_ext.user_default.dimple.addon import canvas, comparison_chart

    if not hasattr(gpu, "init"):
        pytest.skip("this Blender cannot draw without a window; 5.2 can")
    gpu.init()
    found = comparison_chart.load(body.dimple)
    picture = on_screen(lambda screen: comparison_chart.draw_chart(found, (0.6, 0.5), (60.0, 60.0), screen))
    for colour in (comparison_chart.PROXIES, canvas.FORCE, canvas.ink()):
        assert (abs(picture[:, :, :3] / 255.0 - colour[:3]).max(axis=2) < 0.12).sum() > 20, colour


def test_dearer_lies_farther_right_and_worse_higher(bpy: ModuleType, body: Any) -> None:
    from bl_ext.user_default.dimple.addon import comparison_chart

    low, high = comparison_chart.decades([0.01, 1.0])
    assert -2.2 < low < -2 and 0 < high < 0.5, "two decades with room at both ends"
    places = comparison_chart.places(comparison_chart.load(body.dimple), (0.6, 0.5), (0.0, 0.0), (100.0, 100.0))
    proxies = places[2:5]
    assert [x for x, _ in proxies] == sorted(x for x, _ in proxies)
    assert [y for _, y in proxies] == sorted((y for _, y in proxies), reverse=True)
    assert all(0 <= x <= 100 and 0 <= y <= 100 for x, y in (places[0], *places[2:]))


def test_no_name_lies_over_another_or_beside_the_chart(
    bpy: ModuleType, body: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import canvas, comparison_chart

    names: list[tuple[float, float, float]] = []

    def write(text: str, at: Any, scale: float, *_: Any) -> float:
        names.append((*at, canvas.width(text, scale)))
        return names[-1][2]

    for name, fake in (("draw_lines", lambda *_: None), ("draw_filled", lambda *_: None), ("write", write)):
        monkeypatch.setattr(canvas, name, fake)
    monkeypatch.setattr(canvas, "width", lambda text, _scale: 7.0 * len(text))
    found = comparison_chart.load(body.dimple)
    crowded = [*found, found[1] | {"vertices": 201, "cost": found[1]["cost"] * 1.1}]
    comparison_chart.draw_chart(crowded, (0.6, 0.5), (60.0, 60.0), SCREEN)
    variants = names[2:-1]  # after the limits, before what the axes are
    assert len(variants) == len(crowded) - 1, "of two that are as good as one only the first is named"
    assert all(comparison_chart.apart(one, other, 1.0) for i, one in enumerate(variants) for other in variants[:i])
    assert all(x + wide <= 60 + comparison_chart.SIZE[0] + 2 * canvas.MARGIN for x, _, wide in variants)


def test_the_chart_is_drawn_only_where_it_and_the_overlays_are_switched_on(
    bpy: ModuleType, body: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import comparison_chart

    drawn: list[Any] = []
    monkeypatch.setattr(comparison_chart, "draw_chart", lambda *given: drawn.append(given))
    window_manager = SimpleNamespace(dimple=SimpleNamespace(show_comparison=True))
    context = viewport(bpy, object=body, window_manager=window_manager)
    monkeypatch.setattr(comparison_chart, "bpy", SimpleNamespace(context=context))
    comparison_chart.draw_over()
    assert len(drawn) == 1 and len(drawn[0][0]) == len(FOUND)
    context.space_data.overlay.show_overlays = False
    comparison_chart.draw_over()
    context.space_data.overlay.show_overlays, window_manager.dimple.show_comparison = True, False
    comparison_chart.draw_over()
    assert len(drawn) == 1
    window_manager.dimple.show_comparison = True
    comparison_chart.draw_over()
    assert len(drawn) == 2


def test_nothing_is_drawn_of_an_object_that_was_not_compared(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon import comparison_chart

    comparison_chart.draw_over()  # no object
    empty_file.ops.mesh.primitive_cube_add()
    bpy.context.window_manager.dimple.show_comparison = True
    comparison_chart.draw_over()
    for damaged in ("", "{", "[]", '{"variants": 1}'):
        assert comparison_chart.load(SimpleNamespace(comparison=damaged)) == []
    bpy.context.window_manager.dimple.show_comparison = False
