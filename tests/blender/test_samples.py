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
    from bl_ext.user_default.dimple.core.material import Material

    bpy.context.scene.dimple.cache_dir = str(tmp_path)
    bpy.ops.dimple.bake(frame_start=1, frame_end=HELD)
    assert len(bodies) == 3
    for body in bodies:
        (path,) = tmp_path.glob(f"*{bpy.path.clean_name(body.name)}*.csv")
        material = Material(**body.active_material.dimple.to_params())
        with path.open(newline="") as file:
            *_, last = csv.DictReader(file)
        finger = max("123", key=lambda i: float(last[f"depth_{i}_mm"]))
        law = material.law(float(last[f"depth_{finger}_mm"]) / 1e3)
        assert float(last[f"force_{finger}_n"]) == pytest.approx(law, rel=0.01), path
