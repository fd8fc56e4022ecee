"""A material travels as one small file: saved, and the same where it is opened; a bad file is refused."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.operators.test_calibrate import SAMPLE


def values(settings: Any) -> dict[str, Any]:
    from bl_ext.user_default.dimple.operators.calibrate.material_file import VALUES

    return {name: getattr(settings, name) for name in VALUES}


def test_a_saved_material_is_the_same_where_it_is_opened(
    bpy: ModuleType, add: Callable[..., Any], tmp_path: Path
) -> None:
    body, path = add(), tmp_path / "cushion.dimple"
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE), tip="PUNCH", tip_radius_mm=4)
    bpy.ops.dimple.apply_calibration()
    before = values(body.active_material.dimple)
    bpy.ops.dimple.save_material(filepath=str(path), license="CC-BY-4.0")
    saved = json.loads(path.read_text("utf-8"))
    assert saved["license"] == "CC-BY-4.0" and saved["date"] and path.stat().st_size < 30_000
    low, high = saved["calibration"]["K1_interval"]
    assert low < saved["K1"] < high and saved["calibration"]["source"] == SAMPLE.name
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.dimple")
    bpy.ops.mesh.primitive_cube_add()
    assert bpy.ops.dimple.open_material(filepath=str(path)) == {"FINISHED"}
    other = bpy.context.object
    assert values(other.active_material.dimple) == before
    assert other.dimple.enabled and other.active_material.name == saved["name"]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "not a material"), ("[1]", "not a material"), ("{}", "not a material"), ("\x00\xff", "not a material"),
        ('{"calibration": {}, "K1": -1, "K2": 1, "k": 1, "x0": 1}', "K1 must be greater than 0"),
        ('{"calibration": {}, "K1": 1, "K2": 2, "k": 1, "x0": 5, "name": "x"}', "not a material"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_material_is_refused(
    bpy: ModuleType, add: Callable[..., Any], tmp_path: Path, text: str, what: str
) -> None:
    body, path = add(), tmp_path / "bad.dimple"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(RuntimeError, match=what):
        bpy.ops.dimple.open_material(filepath=str(path))
    assert not body.dimple.enabled


def test_a_file_with_one_bad_value_changes_no_material(
    bpy: ModuleType, add: Callable[..., Any], tmp_path: Path
) -> None:
    body, path = add(), tmp_path / "cushion.dimple"
    bpy.context.object.dimple.material = "flesh"
    bpy.ops.dimple.save_material(filepath=str(path))
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | {"K1": 5.0, "fill": "lead"}), "utf-8")
    before, materials = values(body.active_material.dimple), set(bpy.data.materials.keys())
    with pytest.raises(RuntimeError, match="not a material that Dimple saved"):
        bpy.ops.dimple.open_material(filepath=str(path))
    assert values(body.active_material.dimple) == before and set(bpy.data.materials.keys()) == materials


def test_a_material_that_is_dropped_into_a_viewport_is_opened(bpy: ModuleType) -> None:
    handler = bpy.types.DIMPLE_FH_material
    assert (handler.bl_import_operator, handler.bl_file_extensions) == ("dimple.open_material", ".dimple")
    assert handler.poll_drop(SimpleNamespace(area=SimpleNamespace(type="VIEW_3D")))
    assert not handler.poll_drop(SimpleNamespace(area=None))
