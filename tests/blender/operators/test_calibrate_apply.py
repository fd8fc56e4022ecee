"""A calibration becomes a material: applied, undone, kept as a preset."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_calibrate import DEPTH, FORCE, SAMPLE, record_of


def test_a_k_that_is_not_taken_is_not_in_the_source(bpy: ModuleType, add: Callable[..., Any]) -> None:
    add()
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE), length_mm=150)
    bpy.ops.dimple.apply_calibration(use_k=False)
    settings = bpy.context.object.active_material.dimple
    assert "force balance" not in settings.provenance and settings.provenance


def test_apply_sets_constants_tip_size_and_source_and_one_undo_takes_them_back(
    bpy: ModuleType, add: Callable[..., Any]
) -> None:
    from bl_ext.user_default.dimple.core.message import read

    add()
    scene = bpy.context.scene.dimple
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE), length_mm=150, tip="PUNCH", tip_radius_mm=4)
    bpy.ops.ed.undo_push(message="Calibrate")
    result = record_of(scene)
    assert bpy.ops.dimple.apply_calibration() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Apply")
    body = bpy.data.objects["Body"]
    settings = body.active_material.dimple
    for name in ("K1", "K2", "x0"):
        assert getattr(settings, name) == pytest.approx(result[name], rel=1e-6)
    assert settings.k == pytest.approx(result["k"], rel=1e-6)
    assert (settings.tip, settings.tip_radius_mm) == ("PUNCH", 4)
    assert read(settings.provenance) == f"{result['provenance']}; {result['source_of_k']}"
    for part in (SAMPLE.name, "±", "95 %", "residual", f"calibrated {result['date']}"):
        assert part in read(settings.provenance)
    assert body.dimple.enabled and body.dimple.size_mm == 150
    assert bpy.context.scene.dimple.calibration == "" and record_of(settings) == result
    bpy.ops.ed.undo()
    assert bpy.data.objects["Body"].active_material is None
    assert record_of(bpy.context.scene.dimple) == result, "the result waits again"
    bpy.ops.ed.redo()
    assert bpy.data.objects["Body"].active_material.dimple.tip == "PUNCH"


def test_unloading_gives_the_damping_ratio(bpy: ModuleType, add: Callable[..., Any], tmp_path: Path) -> None:
    rows = [(x, f) for x, f in zip(DEPTH, FORCE, strict=True)]
    back = [(x, 0.8 * f) for x, f in reversed(rows[:-1])]
    path = tmp_path / "loop.csv"
    path.write_text("Depth (mm),Force (N)\n" + "".join(f"{x:.4f},{f:.4f}\n" for x, f in rows + back))
    add()
    bpy.ops.dimple.calibrate(filepath=str(path))
    bpy.ops.dimple.apply_calibration()
    settings = bpy.context.object.active_material.dimple
    assert settings.damping_ratio == pytest.approx(0.2 / np.pi, rel=0.05), "a fifth of the work is lost"


def test_constants_that_are_no_material_cannot_be_applied(bpy: ModuleType, add: Callable[..., Any]) -> None:
    add()
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE))
    scene = bpy.context.scene.dimple
    result = record_of(scene)
    assert bpy.ops.dimple.apply_calibration.poll()
    result |= {"K1": -0.5}
    scene.calibration = json.dumps(result)
    assert not bpy.ops.dimple.apply_calibration.poll()


def test_a_preset_keeps_the_calibration_with_its_source_and_that_it_was_edited(
    bpy: ModuleType, add: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Blender gives the popover the name of the preset that was chosen last
    monkeypatch.setattr(bpy.types.DIMPLE_PT_material_presets, "bl_label", "Materials")
    add()
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE))
    bpy.ops.dimple.apply_calibration()
    settings = bpy.context.object.active_material.dimple
    settings.K2 = 9.5  # by hand, so the preset is of an edited material
    kept = ("K1", "K2", "x0", "tip", "calibration", "provenance", "edited")
    before = {name: getattr(settings, name) for name in kept}
    bpy.ops.dimple.material_preset_add(name="My Cushion")
    settings.K1, settings.calibration, settings.tip, settings.provenance = 1.0, "", "SPHERE", ""
    folder = Path(bpy.utils.user_resource("SCRIPTS", path="presets/dimple/material"))
    (path,) = folder.glob("My_Cushion*.py")
    try:
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname="DIMPLE_PT_material_presets")
    finally:
        path.unlink()
    assert {name: getattr(settings, name) for name in before} == before and settings.edited


def test_a_measured_object_of_the_paper_takes_the_place_of_a_calibration(
    bpy: ModuleType, add: Callable[..., Any]
) -> None:
    add()
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE), tip="PUNCH")
    bpy.ops.dimple.apply_calibration()
    settings = bpy.context.object.active_material.dimple
    assert settings.calibration and settings.tip == "PUNCH"
    bpy.context.object.dimple.material = "object_1_nylon_air"
    settings = bpy.context.object.active_material.dimple
    assert (settings.calibration, settings.tip, settings.tip_radius_mm) == ("", "SPHERE", 10)
