"""Force, depth and pressure are keyframed properties of the object, and drive what an artist likes."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.operators.test_bake import table

NAMES = {"dimple_force_n", "dimple_depth_mm", "dimple_pressure_pa"}


def ours(obj: Any) -> set[str]:
    return set(obj.keys()) & NAMES


@pytest.mark.parametrize("target", ["MESH_CACHE", "SHAPE_KEYS"])
def test_a_driver_reads_the_force_of_every_frame(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], target: str
) -> None:
    obj = pressed()
    scene.dimple.use_curves = True
    bpy.ops.dimple.bake(frame_start=1, frame_end=2, target=target)
    lamp = bpy.data.objects.new("Lamp", None)
    bpy.context.collection.objects.link(lamp)
    driver = lamp.driver_add("location", 0).driver
    variable = driver.variables.new()
    driver.type, variable.targets[0].id, variable.targets[0].data_path = "SUM", obj, '["dimple_force_n"]'
    scene.frame_set(2)
    for path in Path(scene.dimple.cache_dir).glob("*.csv"):
        path.unlink()
    bpy.ops.dimple.bake(frame_start=1, frame_end=13, target=target)  # a driver outlives a second bake
    rows = table(obj, scene)
    assert max(row["force_1_n"] for row in rows) > 1
    for frame in (1, 4, 9, 13):
        scene.frame_set(frame)
        row = rows[frame - 1]
        assert obj["dimple_force_n"] == pytest.approx(row["force_1_n"], rel=1e-6)
        assert obj["dimple_depth_mm"] == pytest.approx(row["depth_1_mm"], rel=1e-6)
        assert obj["dimple_pressure_pa"] == pytest.approx(row["pressure_pa"], rel=1e-6)
        assert lamp.evaluated_get(bpy.context.evaluated_depsgraph_get()).location.x == pytest.approx(
            row["force_1_n"], rel=1e-6, abs=1e-5
        )
    bpy.ops.dimple.unbake()
    assert not ours(obj) and obj.animation_data is None


def test_the_keyframes_of_the_artist_stay_when_the_bake_goes(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any]
) -> None:
    obj = pressed()
    obj["mine"] = 1.0
    obj.keyframe_insert("location", frame=1)
    obj.keyframe_insert('["mine"]', frame=2)
    action = obj.animation_data.action
    scene.dimple.use_curves = True
    for _ in range(2):
        bpy.ops.dimple.bake(frame_start=1, frame_end=4)
    assert ours(obj) == NAMES and obj.animation_data.action == action
    curves = action.layers[0].strips[0].channelbag(obj.animation_data.action_slot).fcurves
    assert len(curves) == 4 + 3
    scene.dimple.use_curves = False
    bpy.ops.dimple.bake(frame_start=1, frame_end=4)
    assert not ours(obj) and len(curves) == 4 and obj["mine"] == 1.0


def test_a_recording_has_curves_too(bpy: ModuleType, scene: Any, ball: Callable[..., Any]) -> None:
    obj = ball()
    scene.dimple.use_curves = True
    bpy.ops.dimple.poke(record=True, press_s=0.25, hold_s=0.0, release_s=0.25)
    scene.frame_set(6)
    assert ours(obj) == NAMES and obj["dimple_force_n"] > 0.1 and obj["dimple_depth_mm"] > 1
