"""The comparison's chart shows every way that was tried where its cost and its error put it."""

import json
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.test_overlay import on_screen

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
    from bl_ext.user_default.dimple.addon import methods, overlay

    if not hasattr(gpu, "init"):
        pytest.skip("this Blender cannot draw without a window; 5.2 can")
    gpu.init()
    found = methods.load(body.dimple)
    picture = on_screen(lambda region: methods.draw_chart(found, (0.6, 0.5), (60.0, 60.0), 1.0, region))
    for colour in (methods.PROXIES, overlay.FORCE, overlay.TEXT):
        assert (abs(picture[:, :, :3] / 255.0 - colour[:3]).max(axis=2) < 0.12).sum() > 20, colour


def test_dearer_lies_farther_right_and_worse_higher(bpy: ModuleType, body: Any) -> None:
    from bl_ext.user_default.dimple.addon import methods

    low, high = methods.decades([0.012, 1.0])
    assert low < -1.92 and high > 0
    places = methods.places(methods.load(body.dimple), (0.6, 0.5), (0.0, 0.0), (100.0, 100.0))
    proxies = places[2:5]
    assert [x for x, _ in proxies] == sorted(x for x, _ in proxies)
    assert [y for _, y in proxies] == sorted((y for _, y in proxies), reverse=True)
    assert all(0 <= x <= 100 and 0 <= y <= 100 for x, y in (places[0], *places[2:]))


def test_no_name_lies_over_another_or_beside_the_chart(
    bpy: ModuleType, body: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import methods, overlay

    names: list[tuple[float, float, float]] = []

    def write(text: str, at: Any, scale: float, *_: Any) -> float:
        names.append((*at, overlay.width(text, scale)))
        return names[-1][2]

    for name, stand_in in (("draw_lines", lambda *_: None), ("draw_filled", lambda *_: None), ("write", write)):
        monkeypatch.setattr(overlay, name, stand_in)
    monkeypatch.setattr(overlay, "width", lambda text, _scale: 7.0 * len(text))
    found = methods.load(body.dimple)
    crowded = [*found, found[1] | {"vertices": 201, "cost": found[1]["cost"] * 1.1}]
    methods.draw_chart(crowded, (0.6, 0.5), (60.0, 60.0), 1.0, None)
    variants = names[2:-1]  # after the limits, before what the axes are
    assert len(variants) == len(crowded) - 1, "of two that are as good as one only the first is named"
    assert all(methods.apart(one, other, 1.0) for i, one in enumerate(variants) for other in variants[:i])
    assert all(x + wide <= 60 + methods.SIZE[0] + 2 * overlay.MARGIN for x, _, wide in variants)


def test_nothing_is_drawn_of_an_object_that_was_not_compared(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon import methods

    methods.draw_over()  # no object
    empty_file.ops.mesh.primitive_cube_add()
    bpy.context.window_manager.dimple.show_comparison = True
    methods.draw_over()
    for damaged in ("", "{", "[]", '{"variants": 1}'):
        assert methods.load(SimpleNamespace(comparison=damaged)) == []
    bpy.context.window_manager.dimple.show_comparison = False
