"""Blender's own exporters that would silently write a still of a bake are warned of in their dialogs."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.blender.export.reading import imported, seen
from tests.blender.test_panels import draw

GLTF = {"bl_idname": "EXPORT_SCENE_OT_gltf", "use_selection": False}
FBX = {"bl_idname": "EXPORT_SCENE_OT_fbx", "use_selection": False}


@pytest.mark.parametrize(
    ("dialog", "warned"),
    [(GLTF, True), (FBX, True), ({"bl_idname": "WM_OT_alembic_export", "use_selection": False}, False)],
)
def test_the_warning_is_shown_just_where_blender_writes_a_still(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, dialog: dict, warned: bool
) -> None:
    """What Blender writes is read back: the warning is no guess."""
    from bl_ext.user_default.dimple.addon.still_warning import stills

    pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=6)
    scene.frame_start, scene.frame_end = 1, 6
    assert stills(bpy.context, SimpleNamespace(**dialog)) == (["Ball"] if warned else [])
    path = str(tmp_path / "own")
    if dialog["bl_idname"] == "EXPORT_SCENE_OT_gltf":
        bpy.ops.export_scene.gltf(filepath=path + ".glb")
        obj = imported(bpy, lambda: bpy.ops.import_scene.gltf(filepath=path + ".glb"))
    elif dialog["bl_idname"] == "EXPORT_SCENE_OT_fbx":
        bpy.ops.export_scene.fbx(filepath=path + ".fbx", object_types={"MESH"})
        obj = imported(bpy, lambda: bpy.ops.import_scene.fbx(filepath=path + ".fbx"))
    else:
        bpy.ops.wm.alembic_export(filepath=path + ".abc", as_background_job=False)
        obj = imported(bpy, lambda: bpy.ops.wm.alembic_import(filepath=path + ".abc", as_background_job=False))
    found = seen(bpy, obj, range(0, 9))
    assert (np.abs(found - found[0]).max() < 1e-6) == warned


def test_the_warning_names_the_objects_and_the_way_out(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any]
) -> None:
    pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=2)
    browser = SimpleNamespace(active_operator=SimpleNamespace(**GLTF))
    drawn = " ".join(" ".join(draw(bpy, bpy.types.DIMPLE_PT_still_warning, space_data=browser)).split())
    assert "without their motion: Ball File > Export > Dimple Animation exports them" in drawn
    browser = SimpleNamespace(active_operator=None)
    assert draw(bpy, bpy.types.DIMPLE_PT_still_warning, space_data=browser) == []
