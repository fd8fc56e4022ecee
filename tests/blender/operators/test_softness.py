"""A table of pokes paints the softness that a press then feels."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest


@pytest.mark.once
def test_pokes_paint_a_map_that_makes_the_press_as_stiff_as_it_was_poked(
    bpy: ModuleType, ball: Callable[..., Any], tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.core.material import DEFAULT_MATERIAL
    from bl_ext.user_default.dimple.operators.bridge import scene_objects

    obj = ball(subdivisions=4)
    random = np.random.default_rng(0)
    towards = random.normal(size=(60, 3))
    points = 82.5 * towards / np.linalg.norm(towards, axis=1, keepdims=True)
    twice = np.where(points[:, 0] > 0, 2.0, 0.5)
    forces = twice * DEFAULT_MATERIAL.law(0.008)
    rows = [f"{x:.3f},{y:.3f},{z:.3f},8.0,{f:.4f}" for (x, y, z), f in zip(points, forces, strict=True)]
    path = tmp_path / "robot.csv"
    path.write_text("x (mm),y (mm),z (mm),depth (mm),force (N)\n" + "\n".join(rows))
    assert bpy.ops.dimple.softness_from_pokes(filepath=str(path)) == {"FINISHED"}
    assert obj.dimple.softness_group in obj.vertex_groups
    _, model = scene_objects.read_body(bpy.context, obj)
    per_area, x = model.matching.k1 / model.mesh.vertex_areas, model.mesh.rest_positions[:, 0]
    ratio = np.median(per_area[x > 0.05]) / np.median(per_area[x < -0.05])
    assert ratio == pytest.approx(4.0, rel=0.25)


def test_a_table_that_is_none_changes_nothing(bpy: ModuleType, ball: Callable[..., Any], tmp_path: Path) -> None:
    obj = ball(subdivisions=3)
    path = tmp_path / "curve.csv"
    path.write_text("depth,force\n" + "1,2\n2,3\n" * 10)
    with pytest.raises(RuntimeError, match="no column x, y, z"):
        bpy.ops.dimple.softness_from_pokes(filepath=str(path))
    assert not obj.vertex_groups and not obj.dimple.softness_group
