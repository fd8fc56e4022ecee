"""A start prepares each body once, says what of the scene does not act, and leaves nothing behind where it fails."""

from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.operators.test_sessions import is_clean
from tests.point_cache import cache_of

MANY = 20


def balls(bpy: ModuleType, count: int) -> list[Any]:
    """Add balls of 642 vertices, each with a mesh of its own, and select them."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    first = bpy.context.object
    made = [first]
    for k in range(1, count):
        obj = first.copy()
        obj.data, obj.location.x = first.data.copy(), 3.0 * k
        bpy.context.collection.objects.link(obj)
        obj.select_set(True)
        made.append(obj)
    return made


def counted(monkeypatch: pytest.MonkeyPatch, calls: Counter[str], module: Any, name: str) -> None:
    """Count the calls of a function of a module."""
    real = getattr(module, name)
    monkeypatch.setattr(module, name, lambda *given, **named: calls.update([name]) or real(*given, **named))


@pytest.mark.once
def test_of_twenty_bodies_pressed_at_once_each_is_prepared_once(
    bpy: ModuleType, empty_file: ModuleType, hand: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.reduction import proxy
    from bl_ext.user_default.dimple.operators.bridge import scene_objects
    from bl_ext.user_default.dimple.operators.press import progress, sessions

    bodies, calls, poke = balls(bpy, MANY), Counter[str](), hand("poke")
    for module, name in ((scene_objects, "_mesh"), (proxy, "build_proxy")):
        counted(monkeypatch, calls, module, name)
    monkeypatch.setattr(progress, "LARGE", 1e9)  # at once, not between Blender's events
    assert poke.invoke() == {"RUNNING_MODAL"}
    assert len(sessions.sessions) == len(bodies) == calls["_mesh"] and calls["build_proxy"] <= len(bodies)
    said = [text for _, text in poke.reports]
    assert said and f"{MANY} bodies: 2 m across as modeled" in said[-1] and len(said[-1]) < 1000
    poke.send("ESC")


@pytest.mark.parametrize("name", ["poke", "play"])
def test_a_start_that_fails_leaves_nothing_behind(
    bpy: ModuleType, empty_file: ModuleType, sessions: Any, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    from bl_ext.user_default.dimple.operators.bridge import press_modifier

    add, bodies = press_modifier.add, balls(bpy, 2)

    def failing(body: Any, *how: Any) -> Any:
        modifier = add(body, *how)
        if body == bodies[1]:
            raise RuntimeError("No more modifiers")
        return modifier

    monkeypatch.setattr(press_modifier, "add", failing)
    with pytest.raises(RuntimeError, match="No more modifiers"):
        getattr(bpy.ops.dimple, name)()
    assert not sessions.sessions and is_clean(bodies[0])
    assert not any(body.modifiers or body.dimple.is_property_set("size_mode") for body in bodies[1:])
    assert not any(body.modifiers for body in bodies)


def test_what_of_a_scene_does_not_act_is_said(
    bpy: ModuleType, scene: Any, ball: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    obj = ball()
    bpy.ops.dimple.add_fingertip()
    scene.dimple.finger_1.hide_viewport = True
    bpy.ops.object.effector_add(type="WIND")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.ops.dimple.bake(frame_start=1, frame_end=2)
    Path(cache_of(obj).filepath).unlink()
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.ops.dimple.play(seconds=0.01)
    said = capfd.readouterr().out
    assert "is disabled in the viewport, so it does not move" in said
    assert "other force fields of the scene do not act on the body" in said
    assert 'The file that "Dimple" plays is gone: bake again.' in said
    bpy.ops.dimple.reset()
