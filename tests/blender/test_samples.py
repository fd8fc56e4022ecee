"""What ships in blend_samples/ still holds for the meshes as they are cut and pressed now."""

import csv
from pathlib import Path
from types import ModuleType

import pytest

SAMPLES = Path(__file__).parents[2] / "blend_samples"
HELD = 20  # the last frame on which the fingertips are at their deepest


@pytest.mark.once
def test_a_bake_of_the_three_objects_answers_the_law_where_their_fingertips_are_deepest(
    bpy: ModuleType, empty_file: ModuleType, tmp_path: Path
) -> None:
    """As the demo bakes them: planned, along their keyframes."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / "three_objects.blend"))
    bodies = [obj for obj in bpy.context.scene.objects if obj.dimple.enabled]
    for obj in bpy.context.scene.objects:
        obj.select_set(obj in bodies)
    bpy.context.view_layer.objects.active = bodies[0]
    bpy.context.scene.dimple.cache_dir = str(tmp_path)
    bpy.ops.dimple.bake(frame_start=1, frame_end=HELD)
    tables = sorted(tmp_path.glob("*.csv"))
    assert len(tables) == len(bodies) == 3
    for path in tables:
        with path.open(newline="") as file:
            *_, last = csv.DictReader(file)
        finger = max("123", key=lambda i: float(last[f"depth_{i}_mm"]))
        assert float(last[f"force_{finger}_n"]) == pytest.approx(float(last[f"law_force_{finger}_n"]), rel=0.03), path
