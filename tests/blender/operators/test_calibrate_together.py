"""Several files of one object become one material, with the spread that their tips determine."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

SPREAD = 0.02  # [m]


@pytest.fixture
def files(bpy: ModuleType, tmp_path: Path) -> Path:
    """A folder with the curves of two tips on a bed under a membrane, as the closed form has them."""
    from bl_ext.user_default.dimple.core.body.estimate import bed_area
    from bl_ext.user_default.dimple.core.material import Indenter

    depths = np.linspace(0, 0.01, 41)[1:]
    for name, shape, radius in (("ball_8mm.csv", "sphere", 0.008), ("punch r15.csv", "punch", 0.015)):
        tip = Indenter(shape=shape, radius=radius)
        rows = [(x, 6e5 * bed_area(tip, 0.165, SPREAD, x)[0] * x) for x in depths.tolist()]
        text = "".join(f"{1e3 * x:.4f},{f:.5f}\n" for x, f in [(0.0, 0.0), *rows])
        (tmp_path / name).write_text("Depth (mm),Force (N)\n" + text)
    return tmp_path


TWO = [
    {"name": "ball_8mm.csv", "tip": "SPHERE", "tip_radius_mm": 8.0},
    {"name": "punch r15.csv", "tip": "PUNCH", "tip_radius_mm": 15.0},
]


def test_two_tips_make_a_material_with_their_spread_and_the_panel_shows_each_curve(
    bpy: ModuleType, add: Callable[..., Any], files: Path
) -> None:
    from bl_ext.user_default.dimple.addon import calibrated

    add()
    assert bpy.ops.dimple.calibrate_together(directory=str(files), files=TWO) == {"FINISHED"}
    record = json.loads(bpy.context.scene.dimple.calibration)
    low, high = record["spread_interval"]
    assert low < 20 < high and record["tip"] == "sphere"
    shown = dict(calibrated.rows(record))
    assert "mm" in shown["Spread"] and "full scale" in shown["ball_8mm.csv"] and "full scale" in shown["punch r15.csv"]
    assert bpy.ops.dimple.apply_calibration() == {"FINISHED"}
    settings = bpy.context.object.active_material.dimple
    assert settings.spread_mm == pytest.approx(20, rel=0.05) and settings.tip_radius_mm == 8.0
    assert "ball_8mm.csv, punch r15.csv" in settings.provenance and not settings.edited


def test_one_tip_twice_leaves_the_spread_as_it_was(bpy: ModuleType, add: Callable[..., Any], files: Path) -> None:
    add()
    text = (files / "punch r15.csv").read_text()
    (files / "again.csv").write_text(text)
    same = [TWO[1], TWO[1] | {"name": "again.csv"}]
    bpy.ops.dimple.calibrate_together(directory=str(files), files=same)
    bpy.ops.dimple.apply_calibration()
    assert bpy.context.object.active_material.dimple.spread_mm == 0, "it follows from k"
    assert json.loads(bpy.context.object.active_material.dimple.calibration)["spread_interval"][1] is None


def test_the_name_of_a_file_says_its_tip(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators.calibrate_together import tip_from_name

    for name, tip, radius in (
        ("ball_8mm.csv", "SPHERE", 8.0), ("Punch r15.txt", "PUNCH", 15.0), ("a-sphere 2.5 mm.csv", "SPHERE", 2.5),
        ("run.csv", "POINT", 3.0),
    ):  # fmt: skip
        each = SimpleNamespace(name=name, tip="POINT", tip_radius_mm=3.0)
        tip_from_name(each)
        assert (each.tip, each.tip_radius_mm) == (tip, radius)


def test_a_file_that_leaves_something_open_is_named_and_nothing_is_lost(
    bpy: ModuleType, add: Callable[..., Any], files: Path
) -> None:
    add()
    bpy.context.scene.dimple.calibration = "{}"
    (files / "bare.csv").write_text("".join(f"{i},{2 * i}\n" for i in range(40)))
    with pytest.raises(RuntimeError, match="bare.csv is ambiguous"):
        bpy.ops.dimple.calibrate_together(directory=str(files), files=[TWO[0], TWO[1] | {"name": "bare.csv"}])
    assert bpy.context.scene.dimple.calibration == "{}"
