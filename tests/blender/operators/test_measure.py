"""A virtual press, measured and written as an instrument would, read back, cancelled."""

import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest


def test_what_is_measured_calibrates_to_its_material(bpy: ModuleType, vinyl: Any, tmp_path: Path) -> None:
    """The round trip: constants, measured by a virtual press, fitted again."""
    bpy.context.scene.cursor.location = (0.0, 0.0, 1.0)
    path = tmp_path / "round.csv"
    assert bpy.ops.dimple.measure(filepath=str(path), rows=40, place="CURSOR") == {"FINISHED"}
    text = path.read_text()
    assert "Distance x (mm)" in text and "Simulated by Dimple" in text
    assert bpy.ops.dimple.calibrate(filepath=str(path)) == {"FINISHED"}
    record = json.loads(bpy.context.scene.dimple.calibration)
    assert record["model"] == "two"
    assert record["K1"] == pytest.approx(0.61, rel=0.005)
    assert record["K2"] == pytest.approx(7.23, rel=0.005)
    assert record["x0"] == pytest.approx(16.3, rel=0.005)
    bpy.ops.dimple.apply_calibration()
    assert "round.csv" in vinyl.provenance


def test_another_tip_presses_and_leaves_the_material_as_it_was(bpy: ModuleType, vinyl: Any, tmp_path: Path) -> None:
    path = tmp_path / "finger.csv"
    bpy.ops.dimple.measure(filepath=str(path), tip_radius_mm=15, depth_mm=8, rows=12)
    assert vinyl.tip_radius_mm == 10
    assert "sphere, radius 15 mm" in path.read_text()
    rows = np.loadtxt(path, delimiter=",", skiprows=4)
    assert rows[-1] == pytest.approx([8, rows[:, 1].max()]) and rows[-1, 1] > 1, "it presses, and harder as it goes in"


def test_a_body_that_nothing_holds_is_not_measured(bpy: ModuleType, vinyl: Any, cube: Any, tmp_path: Path) -> None:
    cube.dimple.pinned = False
    with pytest.raises(RuntimeError, match="Nothing holds"):
        bpy.ops.dimple.measure(filepath=str(tmp_path / "free.csv"))


def test_a_measurement_between_blenders_events_is_written_at_its_end_or_not_at_all(
    bpy: ModuleType, vinyl: Any, hand: Any, tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators.press import progress

    path = tmp_path / "live.csv"
    slice_s, progress.SLICE_S = progress.SLICE_S, 0.0
    try:
        for key in ("ESC", ""):
            run = hand("measure")
            run.given.add("filepath")
            run.operator.filepath, run.operator.rows, run.operator.depth_mm = str(path), 12, 5.0
            run.invoke()
            run.ticks(3)
            if key:
                assert run.send(key) == {"CANCELLED"} and not path.exists()
    finally:
        progress.SLICE_S = slice_s
    assert run.ticks(100) == {"FINISHED"}
    rows = np.loadtxt(path, delimiter=",", skiprows=4)
    assert rows.shape == (12, 2) and rows[-1, 0] == pytest.approx(5) and (np.diff(rows[:, 1]) > 0).all()


def test_a_measurement_can_be_cancelled_while_it_asks_for_the_file(bpy: ModuleType, vinyl: Any, hand: Any) -> None:
    """Blender does that where a window with a file browser closes."""
    run = hand("measure")
    assert run.invoke() == {"RUNNING_MODAL"}
    run.operator.cancel(run.context)
    assert bpy.ops.dimple.measure.poll(), "nothing is left at work"


def test_a_measurement_stops_before_the_far_side(bpy: ModuleType, vinyl: Any, cube: Any, tmp_path: Path) -> None:
    cube.scale.z = 0.1
    bpy.ops.dimple.measure(filepath=str(tmp_path / "thin.csv"), depth_mm=400, rows=12)
    rows = np.loadtxt(tmp_path / "thin.csv", delimiter=",", skiprows=4)
    assert rows[-1, 0] <= 0.9 * 16.5 + 1e-3


def test_a_measurement_without_a_path_is_refused_and_writes_nothing(
    bpy: ModuleType, vinyl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RuntimeError, match="Choose a path"):
        bpy.ops.dimple.measure(depth_mm=5)
    assert not list(tmp_path.iterdir())
