"""What the export dialog says beforehand: how large the files will be."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.export.reading import ENDINGS, EVERY
from tests.blender.operators.conftest import icosphere

FRAMES = 24


def plan_of(bpy: ModuleType, folder: Path, **changes: Any) -> Any:
    from bl_ext.user_default.dimple.operators.export.export_plan import ExportPlan

    plan = {"objects": [bpy.data.objects["Ball"]], "formats": EVERY, "folder": folder, "first": 1, "last": FRAMES}
    return ExportPlan(**{**plan, **changes})


def size_of(path: Path) -> int:
    return sum(each.stat().st_size for each in (path.iterdir() if path.is_dir() else [path]))


@pytest.mark.parametrize("smooth", [True, False])
def test_the_size_that_is_said_is_the_most_it_can_be(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, smooth: bool
) -> None:
    from bl_ext.user_default.dimple.operators.export import export_plan

    obj = pressed()
    icosphere(obj.data, 4)
    obj.data.polygons.foreach_set("use_smooth", [smooth] * len(obj.data.polygons))
    for frame in range(1, FRAMES + 1):  # every frame differs from all before, for files keep what repeats once
        scene.dimple.finger_1.location.z += 0.001 * (-1) ** frame - 0.0003
        scene.dimple.finger_1.keyframe_insert("location", index=2, frame=frame)
    bpy.ops.dimple.export_animation(directory=str(tmp_path), formats=set(EVERY), frame_start=1, frame_end=FRAMES)
    for each, ending in zip(EVERY, ENDINGS, strict=True):
        plan = plan_of(bpy, tmp_path, formats=(each,))
        said = export_plan.estimate(plan, [export_plan.size_of(bpy.context, obj, plan)])
        real = size_of(tmp_path / f"Ball{ending}")
        print(f"{each}: {said:.0f} bytes for {real}, {said / real:.2f}")
        assert real <= said < 2 * real + 1e6, f"{each}: {said:.0f} bytes for {real}"


def test_the_size_counts_the_vertices_that_a_simulation_adds(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators.export import export_plan

    obj = pressed()
    obj.dimple.simulated = "AUTO"
    said = export_plan.size_of(bpy.context, obj, plan_of(bpy, tmp_path)).vertices
    bpy.ops.dimple.export_animation(directory=str(tmp_path), formats={"PC2"}, frame_start=1, frame_end=2)
    real = json.loads((tmp_path / "Ball.json").read_text())["files"]["Ball.pc2"]["vertices"]
    assert 42 < real <= said + 2 < 1.5 * real, "a closed mesh has two vertices more than quads"


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.2, "<1 s"), (47.6, "48 s"), (59.7, "1 min 0 s"), (185, "3 min 5 s"), (7800, "2 h 10 min")]
)
def test_a_time_is_said_as_one_reads_it(bpy: ModuleType, seconds: float, text: str) -> None:
    from bl_ext.user_default.dimple.operators.reporting import duration

    assert duration(seconds) == text
