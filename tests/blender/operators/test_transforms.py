"""What a bake or a file cannot hold is refused with the reason, and what has no effect is said."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


def test_a_stretched_time_is_refused(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    pressed()
    scene.render.frame_map_new = 200
    with pytest.raises(RuntimeError, match="Time Stretching is on"):
        bpy.ops.dimple.bake(frame_start=1, frame_end=5)


def test_a_sheared_object_is_refused_by_the_export(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    obj, parent = pressed(), bpy.data.objects.new("Parent", None)
    scene.collection.objects.link(parent)
    obj.parent, obj.rotation_euler, parent.scale = parent, (0.4, 0, 0), (1, 1.3, 0.8)
    bpy.context.view_layer.update()
    frames = {"frame_start": 1, "frame_end": 3, "directory": str(tmp_path), "overwrite": True}
    for each in ("GLB", "ALEMBIC"):
        with pytest.raises(RuntimeError, match="sheared"):
            bpy.ops.dimple.export_animation(formats={each}, **frames)


def test_what_does_not_act_on_a_body_is_said(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    from bl_ext.user_default.dimple.operators.bridge import scene_objects

    obj = pressed()

    def said() -> str:
        return str(scene_objects.read_body(bpy.context, obj)[1].notes)

    assert "force fields" not in said() and "is disabled in the viewport" not in said()
    bpy.ops.object.effector_add(type="WIND")
    scene.dimple.finger_1.hide_viewport = True
    assert "Wind and other force fields of the scene do not act" in said()
    assert "is disabled in the viewport" in said()
