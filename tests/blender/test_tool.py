"""The poke is at hand: a tool with an icon of its own and its settings, in the Object menu, and found by F3."""

import math
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest


def test_the_icon_is_one_that_blender_reads_and_is_drawn_by_its_script(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon.tool import DIMPLE_WT_poke

    from tools import icon

    path = DIMPLE_WT_poke.bl_icon + ".dat"
    assert bpy.app.icons.new_triangles_from_file(path) > 0
    assert open(path, "rb").read() == icon.PATH.read_bytes() == icon.encoded()


def drawn(function: Any, *given: Any) -> list[str]:
    """Return the names of what a draw function draws."""
    names: list[str] = []

    def note(*arguments: Any, **_: Any) -> Any:
        names.append(str(arguments[-1]))
        return SimpleNamespace()

    layout = SimpleNamespace(prop=note, operator=note, menu=note, separator=lambda: None, row=lambda **_: layout)
    function(*[layout if each == "layout" else SimpleNamespace(layout=layout) if each == "self" else each
               for each in given])  # fmt: skip
    return names


def test_the_header_of_the_tool_has_depth_or_force(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon.tool import DIMPLE_WT_poke

    depth, force = "press_depth_mm", "press_force_n"
    for by, shown, hidden in (("DEPTH", depth, force), ("FORCE", force, depth)):
        bpy.context.scene.dimple.press_by = by
        names = drawn(DIMPLE_WT_poke.draw_settings, bpy.context, "layout", None)
        assert {"press_by", shown, "finger_radius_mm", "dimple.key_press"} <= set(names) and hidden not in names


def test_the_keys_that_size_the_fingertip_lead_to_settings_there_are(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon.tool import DIMPLE_WT_poke

    for operator, event, more in DIMPLE_WT_poke.bl_keymap[1:]:
        assert operator == "wm.radial_control" and event["type"] == "F"
        for name, path in more["properties"]:
            value = bpy.context.path_resolve(path)
            assert (len(value) == 2) if name == "zoom_path" else isinstance(value, float | bool)


def test_the_circle_under_the_mouse_is_as_large_as_the_fingertip_and_lies_on_the_body(
    bpy: ModuleType, empty_file: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import tool
    from bl_ext.user_default.dimple.operators.press import poke_input
    from mathutils import Quaternion, Vector

    bpy.ops.mesh.primitive_cube_add(size=2.0)
    cube, scale = bpy.context.object, 100  # [px] of a unit, seen from above
    cube.dimple.size_mode = "CUSTOM"
    views = SimpleNamespace(
        region_2d_to_origin_3d=lambda _r, _v, at: (at[0] / scale, at[1] / scale, 10.0),
        region_2d_to_vector_3d=lambda *_: Vector((0.0, 0.0, -1.0)),
    )
    monkeypatch.setattr(poke_input, "view3d_utils", views)
    monkeypatch.setattr(tool, "location_3d_to_region_2d", lambda _r, _v, at: scale * Vector(at[:2]))
    look = SimpleNamespace(view_rotation=Quaternion())
    sides = tool.circle(bpy.context, poke_input.View(None, look, (30, 40)))
    per_mm = scale * 2 / 165
    assert all(math.dist(a, (30, 40)) == pytest.approx(10 * per_mm) for a, _ in sides) and len(sides) > 8
    assert tool.radius_zoom(None) == pytest.approx((per_mm, per_mm)) == tool.amount_zoom(None)
    bpy.context.scene.dimple.press_by = "FORCE"
    assert tool.amount_zoom(None) != tool.radius_zoom(None)
    assert not tool.circle(bpy.context, poke_input.View(None, look, (130, 0))), "beside it"
    cube.select_set(False)
    assert not tool.circle(bpy.context, poke_input.View(None, look, (30, 40))), "a click would select it"
    cube.dimple.enabled = True
    assert tool.circle(bpy.context, poke_input.View(None, look, (30, 40)))


def test_the_object_menu_has_the_verbs_where_the_search_finds_them(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon import tool

    assert tool.draw_menu in bpy.types.VIEW3D_MT_object.draw._draw_funcs
    assert drawn(tool.draw_menu, "self", None) == ["DIMPLE_MT_object"]
    verbs = drawn(tool.DIMPLE_MT_object.draw, "self", None)
    assert {"dimple.poke", "dimple.make_soft", "dimple.play"} <= set(verbs)
    assert all(hasattr(bpy.ops.dimple, verb.removeprefix("dimple.")) for verb in verbs)
