"""Whatever happens to an export, nothing is lost that was there, and no half file stands under a final name."""

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.export.reading import ENDINGS, EVERY, contents, earlier
from tests.blender.operators.test_disk_full import full_after
from tests.point_cache import cache_of, read_point_cache

Bits = Callable[[Any], bytes]


def steps(bpy: ModuleType, folder: Path, written: list[Path], **changes: Any) -> Iterator[float]:
    from bl_ext.user_default.dimple.operators.export import export_plan

    plan = {"objects": [bpy.data.objects["Ball"]], "formats": EVERY, "folder": folder, "first": 1, "last": 6}
    return export_plan.export(bpy.context, export_plan.ExportPlan(**{**plan, **changes}), [], written)


def test_files_that_are_there_are_kept_unless_they_are_to_be_replaced(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    pressed()
    before = earlier(tmp_path / "out")
    given = {"directory": str(tmp_path / "out"), "formats": {"PC2", "VAT"}, "frame_start": 1, "frame_end": 3}
    with pytest.raises(RuntimeError, match=r"Ball.pc2 and 3 other files already exist.*Overwrite"):
        bpy.ops.dimple.export_animation(**given)
    assert contents(tmp_path / "out") == before
    bpy.ops.dimple.export_animation(**given, overwrite=True)
    now = contents(tmp_path / "out")
    assert now["Ball.pc2"].startswith(b"POINTCACHE2") and now["Ball.abc"] == before["Ball.abc"]
    assert "Ball_vat/earlier" not in now and "Ball_vat/layout.json" in now, "a folder is replaced as a whole"


@pytest.mark.parametrize("kind", EVERY)
def test_a_disk_that_fills_costs_nothing_that_was_there(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], coordinates: Bits, tmp_path: Path, kind: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is seen fits on the disk; what is made of it does not, and only sometimes is that known before."""
    from bl_ext.user_default.dimple.operators.export import export_plan

    if kind != "ALEMBIC":  # it would end Blender
        monkeypatch.setattr(export_plan, "check_space", lambda *_: None)
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=6)
    before, bits, meshes = earlier(tmp_path / "out"), coordinates(obj), len(bpy.data.meshes)
    room = 1500 if kind == "PC2" else 32 + 6 * 42 * 12  # what is seen fits, and the file of the format does not
    with full_after(room), pytest.raises(RuntimeError) as refused:
        bpy.ops.dimple.export_animation(
            directory=str(tmp_path / "out"), formats={kind}, frame_start=1, frame_end=6, overwrite=True
        )
    (sentence,) = str(refused.value).strip().splitlines()
    said = {"ALEMBIC": "more than .* has free"}.get(kind, "File too large|could not finish")
    assert re.search(said, sentence) and str(tmp_path) in sentence
    now = contents(tmp_path / "out")
    assert now.keys() == before.keys(), "no temporary file is left"
    assert {name for name in now if now[name] != before[name]} <= {"Ball.csv"}, "the table was whole already"
    assert coordinates(obj) == bits and [m.name for m in obj.modifiers] == ["Dimple"]
    assert len(bpy.data.meshes) == meshes and scene.frame_current == 1


def test_what_this_blender_cannot_write_is_said_before_anything_is_simulated(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As Debian's, which is built without Alembic and USD."""
    from bl_ext.user_default.dimple.operators.export import formats

    pressed()
    monkeypatch.setattr(formats, "is_there", lambda name: name != "wm.alembic_export")
    with pytest.raises(RuntimeError, match="This Blender cannot write Alembic: .+ Choose another format"):
        bpy.ops.dimple.export_animation(directory=str(tmp_path / "o"), formats={"PC2", "ALEMBIC"}, frame_end=3)
    assert not (tmp_path / "o").exists()


def test_a_folder_that_takes_no_files_is_said(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    pressed()
    (tmp_path / "file").write_text("kept")
    for folder in (tmp_path / "file" / "out", Path("/proc/out")):
        with pytest.raises(RuntimeError, match=r"The export failed at .+: .+\. Choose another folder\."):
            bpy.ops.dimple.export_animation(directory=str(folder), formats={"PC2"}, frame_start=1, frame_end=3)
    assert contents(tmp_path)["file"] == b"kept"


@pytest.mark.parametrize("folder", ["", "//out"])
def test_a_folder_that_is_nowhere_is_said(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], folder: str
) -> None:
    pressed()
    with pytest.raises(RuntimeError, match=r"Choose a folder for the files|Save the file first"):
        bpy.ops.dimple.export_animation(directory=folder, formats={"PC2"}, frame_start=1, frame_end=3)


def test_too_small_a_disk_is_said_before_anything_is_simulated(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import shutil
    from types import SimpleNamespace

    pressed()
    monkeypatch.setattr(shutil, "disk_usage", lambda _path: SimpleNamespace(free=1e4))
    with pytest.raises(RuntimeError, match=r"may need 0\.\d MB, more than .+ has free"):
        bpy.ops.dimple.export_animation(directory=str(tmp_path / "o"), formats={"ALEMBIC"}, frame_start=1, frame_end=90)
    assert contents(tmp_path / "o") == {}


NAMES = ["A ball", "柔らかい球", "x" * 200, "柔" * 80, "a/b\\c:d*e?", ".hidden", "Ball.001", "-rf ~", "é\u0301"]


@pytest.mark.parametrize("name", NAMES)
def test_every_name_of_an_object_has_its_files(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, name: str
) -> None:
    obj = pressed()
    obj.name = name
    folder = tmp_path / "ein Ordner 出力"
    bpy.ops.dimple.export_animation(directory=str(folder), formats=set(EVERY), frame_start=1, frame_end=2)
    endings = sorted(path.name.removeprefix(next(folder.glob("*.pc2")).stem) for path in folder.iterdir())
    assert endings == sorted([*ENDINGS, ".csv", ".json"])
    assert json.loads(next(folder.glob("*.json")).read_text())["object"] == obj.name
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=2) == {"FINISHED"}, "and so has a bake"


def test_two_names_that_look_alike_on_the_disk_have_files_of_their_own(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any], tmp_path: Path
) -> None:
    for obj in [ball("a/b"), ball("a_b"), ball("a" * 62 + "é"), ball("a" * 62 + "è")]:
        obj.select_set(True)
    for obj in bpy.data.objects:
        obj.select_set(True)
    bpy.ops.dimple.export_animation(directory=str(tmp_path), formats={"PC2"}, frame_start=1, frame_end=2)
    assert len(list(tmp_path.glob("*.pc2"))) == 4


def test_a_cancelled_export_keeps_what_is_finished(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], coordinates: Bits, tmp_path: Path
) -> None:
    obj = pressed()
    bits, written = coordinates(obj), []
    scene.frame_set(4)
    begun = steps(bpy, tmp_path, written, formats=("PC2", "ALEMBIC", "VAT"))
    for _ in begun:
        if any(path.suffix == ".abc" for path in written):
            break
    begun.close()
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "caches") == [
        "Ball.abc", "Ball.csv", "Ball.json", "Ball.pc2",
    ]  # fmt: skip
    assert set(json.loads((tmp_path / "Ball.json").read_text())["files"]) == {"Ball.pc2", "Ball.abc"}
    assert coordinates(obj) == bits and not obj.modifiers and scene.frame_current == 4


def test_an_export_that_is_cancelled_while_it_simulates_leaves_nothing(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    pressed()
    begun = steps(bpy, tmp_path / "out", [])
    for _ in range(3):
        assert 0 < next(begun) < 0.5
    begun.close()
    assert contents(tmp_path / "out") == {} and list((tmp_path / "out").iterdir()) == []


def test_what_plays_is_exported_beyond_its_ends_too(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], coordinates: Bits, tmp_path: Path
) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=3, frame_end=8)
    rest = np.frombuffer(coordinates(obj), np.float32).reshape(-1, 3)
    baked = rest + read_point_cache(cache_of(obj).filepath)[2]
    bpy.ops.dimple.export_animation(directory=str(tmp_path), formats={"PC2"}, frame_start=1, frame_end=10)
    start, _, found = read_point_cache(tmp_path / "Ball.pc2")
    assert start == 1 and np.array_equal(found, baked[[0, 0, 0, 1, 2, 3, 4, 5, 5, 5]])


def test_an_object_that_is_hidden_and_shares_a_linked_mesh_is_exported_and_stays_as_it_is(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    obj = pressed()
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {obj.data})
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_there, here):
        here.meshes = ["Ball"]
    obj.data = here.meshes[0]
    obj.hide_set(True)
    for _ in steps(bpy, tmp_path / "out", [], last=3):
        pass
    assert len(list((tmp_path / "out").iterdir())) == len(ENDINGS) + 2
    assert obj.data.library and obj.data.name == "Ball" and obj.hide_get() and not obj.select_get()


def test_a_bake_that_no_longer_fits_the_mesh_is_said(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=3)
    path = Path(cache_of(obj).filepath)
    obj.data.vertices.add(1)
    obj.data.update_tag()
    given = {"directory": str(tmp_path / "o"), "formats": {"PC2"}, "frame_start": 1, "frame_end": 3}
    with pytest.raises(RuntimeError, match="has 43 vertices, but its bake has 42"):
        bpy.ops.dimple.export_animation(**given)
    path.unlink()
    with pytest.raises(RuntimeError, match="cannot be read"):
        bpy.ops.dimple.export_animation(**given)
