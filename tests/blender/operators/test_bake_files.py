"""What a bake leaves on the disk: a cache and a table, all of it or nothing, found again when the project moves."""

import importlib
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_bake import table
from tests.point_cache import cache_of
from tools.environment import ROOT

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
Shown = Callable[[Any], np.ndarray]


def test_the_table_beside_the_cache_has_force_depth_pressure_and_volume(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any]
) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=19)
    rows = table(obj, scene)
    assert [row["frame"] for row in rows] == list(range(1, 20))
    held = rows[11]
    assert held["depth_1_mm"] == pytest.approx(20, abs=1.5)
    assert held["force_1_n"] == pytest.approx(610 * 0.0163 + 7230 * (held["depth_1_mm"] / 1e3 - 0.0163), rel=1e-3)
    assert held["pressure_pa"] > 0
    assert 0.9 < held["volume_m3"] / held["rest_volume_m3"] < 1
    assert rows[0]["force_1_n"] < 1e-4 and held["force_2_n"] == 0
    beyond = held["depth_1_mm"] / 1e3 - 0.0163
    put_in = 610 * 0.0163**2 / 2 + 610 * 0.0163 * beyond + 7230 * beyond**2 / 2
    assert held["work_j"] == pytest.approx(put_in, rel=0.03), "what the law takes on the way in"
    assert -0.03 * put_in < rows[-1]["work_j"] < 0.05 * put_in, "and gives back"


def test_the_demo_sums_up_the_table_that_a_bake_writes(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("matplotlib", "PIL"):  # hidden from the extension, but the demo draws with them
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(ROOT / "blend_samples")
    demo = importlib.import_module("demo")
    obj = pressed()
    obj.active_material = bpy.data.materials.new("Soft")
    bpy.ops.dimple.bake(frame_start=1, frame_end=demo.HELD)
    row = demo.summary_row(obj, table(obj, scene))
    assert row["finite"] and row["force_n"] == pytest.approx(row["law_n"], rel=1e-3)
    assert row["steps"] > 0 and row["vertices"] == row["moving_vertices"] == len(obj.data.vertices)
    assert row["max_depth_mm"] == pytest.approx(20, abs=1.5) and row["volume_error"] < 0.1


def test_several_objects_are_baked_in_one_pass(bpy: ModuleType, scene: Any, ball: Add) -> None:
    bodies = [ball(name) for name in ("One", "Two/three", "Two_three")]
    for obj in bodies:
        obj.select_set(True)
    bpy.ops.dimple.bake(frame_start=5, frame_end=8)
    paths = {cache_of(obj).filepath for obj in bodies}
    assert len(paths) == 3 and all(Path(path).exists() for path in paths)
    assert {cache_of(obj).frame_start for obj in bodies} == {5.0}


def unfinished(bpy: ModuleType, obj: Any, **changes: Any) -> Iterator[float]:
    """Return the steps of a bake that may be stopped."""
    from bl_ext.user_default.dimple.operators.animate import bake_to_files

    plan = {"objects": [obj], "first": 1, "last": 12}
    return bake_to_files.bake(bpy.context, bake_to_files.BakePlan(**{**plan, **changes}), [])


def test_a_cancelled_bake_leaves_nothing_half_done(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], coordinates: Bits
) -> None:
    from bl_ext.user_default.dimple.operators.press.progress import READY

    obj = pressed()
    before = coordinates(obj)
    scene.frame_set(7)
    steps = unfinished(bpy, obj)
    while next(steps) <= READY:
        pass
    for _ in range(4):
        assert READY < next(steps) < 1
    steps.close()
    assert scene.frame_current == 7
    assert list(Path(scene.dimple.cache_dir).iterdir()) == []
    assert not obj.modifiers and coordinates(obj) == before


def test_two_bakes_of_one_scene_write_the_same_bytes(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    """Cache and table: nothing in them tells when, or how fast, they were made."""
    pressed()
    found = []
    for _ in range(2):
        bpy.ops.dimple.bake(frame_start=1, frame_end=12)
        files = sorted(Path(scene.dimple.cache_dir).iterdir())
        found.append({path.suffix: path.read_bytes() for path in files})
        bpy.ops.dimple.unbake()
        for path in files:
            path.unlink()
    assert found[0] == found[1] and found[0].keys() == {".pc2", ".csv"}


def test_a_cancelled_bake_leaves_the_bake_before_it(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=4)
    files = {path.name: path.read_bytes() for path in Path(scene.dimple.cache_dir).iterdir()}
    steps = unfinished(bpy, obj)
    next(steps)
    steps.close()
    assert {path.name: path.read_bytes() for path in Path(scene.dimple.cache_dir).iterdir()} == files
    assert len(obj.modifiers) == 1


def test_a_bake_whose_object_is_deleted_fails_with_a_sentence(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any]
) -> None:
    obj = pressed()
    steps = unfinished(bpy, obj)
    next(steps)
    bpy.data.objects.remove(obj)
    with pytest.raises(ValueError, match='"Ball" is gone'):
        list(steps)
    assert list(Path(scene.dimple.cache_dir).iterdir()) == []


def test_a_bake_whose_object_is_renamed_goes_on(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    obj = pressed()
    steps = unfinished(bpy, obj)
    next(steps)
    obj.name = "Another"
    list(steps)
    assert [modifier.name for modifier in obj.modifiers] == ["Dimple"]


def test_a_bake_beside_a_saved_file_is_found_again_when_the_project_moves(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], shown: Shown, tmp_path: Path
) -> None:
    obj = pressed()
    scene.dimple.cache_dir = ""
    (tmp_path / "here").mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "here" / "press.blend"))
    bpy.ops.dimple.bake(frame_start=1, frame_end=8)
    assert cache_of(obj).filepath == "//press_Ball_bake.pc2"
    scene.frame_set(7)
    seen = shown(obj).copy()
    bpy.ops.wm.save_mainfile()
    shutil.move(tmp_path / "here", tmp_path / "there")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "there" / "press.blend"))
    assert np.array_equal(shown(bpy.data.objects["Ball"]), seen)


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_second_file_without_a_name_leaves_the_bakes_of_the_first_one_alone(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any], tmp_path: Path
) -> None:
    folder = tmp_path / "caches"

    def animate() -> Any:
        obj = ball()
        bpy.context.scene.dimple.cache_dir = str(folder)
        bpy.ops.dimple.bake(frame_start=1, frame_end=3)
        return obj

    animate()
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert cache_of(animate()).filepath.endswith("untitled_Ball_bake_002.pc2")
    assert len(files(folder)) == 4 and all((folder / name).read_bytes() == data for name, data in first.items())


def test_a_second_bake_of_an_object_in_a_file_without_a_name_takes_the_place_of_its_first(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any], tmp_path: Path
) -> None:
    ball()
    for _ in range(2):
        bpy.ops.dimple.bake(frame_start=1, frame_end=3)
    assert files(tmp_path / "caches") == ["untitled_Ball_bake_001.csv", "untitled_Ball_bake_001.pc2"]


def test_bakes_of_a_file_without_a_name_outlive_the_extension(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any]
) -> None:
    scene.dimple.cache_dir = ""
    obj = ball()
    bpy.ops.dimple.bake(frame_start=1, frame_end=3)
    path = Path(cache_of(obj).filepath)
    own = Path(bpy.utils.extension_path_user("bl_ext.user_default.dimple"))
    try:
        assert path.exists() and own not in path.parents, "Blender deletes that folder with the extension"
        assert Path(bpy.utils.user_resource("DATAFILES")) in path.parents
    finally:
        path.unlink()
        path.with_suffix(".csv").unlink()
