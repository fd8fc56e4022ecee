"""What is pressed live can be recorded, and the object plays it."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_bake import cached
from tests.point_cache import cache_of

Add = Callable[..., Any]
Shown = Callable[[Any], np.ndarray]
QUICK: dict[str, Any] = {"depth_mm": 5.0, "press_s": 0.05, "hold_s": 0.0, "release_s": 0.0}


def test_a_recorded_press_is_played_back(bpy: ModuleType, scene: Any, ball: Add, shown: Shown) -> None:
    obj = ball()
    rest = shown(obj).copy()
    scene.frame_set(10)
    bpy.ops.dimple.poke(record=True, press_s=0.25, hold_s=0.25, release_s=0.25)
    start, positions = cached(scene, obj)
    assert start == 10 and len(positions) == 19
    assert cache_of(obj).frame_start == 10
    for frame in (10, 16, 28):
        scene.frame_set(frame)
        assert np.abs(shown(obj) - positions[frame - 10]).max() < 1e-5
    scene.frame_set(20)
    assert np.abs(shown(obj) - rest).max() > 0.1


def test_the_record_button_takes_what_plays_and_needs_something_that_does(
    bpy: ModuleType, scene: Any, ball: Add, shown: Shown
) -> None:
    assert not bpy.ops.dimple.record.poll()
    obj = ball()
    scene.dimple.use_gravity = True
    scene.frame_set(5)
    bpy.ops.dimple.play(seconds=0.05)
    before = shown(obj).copy()
    for _ in range(2):  # start and stop
        assert bpy.ops.dimple.record() == {"FINISHED"}
        bpy.ops.dimple.play(seconds=0.25)
    assert "Dimple" not in obj.modifiers, "not while the session goes on"
    bpy.ops.dimple.reset()
    start, positions = cached(scene, obj)
    assert (start, len(positions)) == (5, 1 + scene.render.fps // 4)
    assert np.abs(positions[0] - before).max() < 1e-6, "it begins with what showed"
    scene.frame_set(5 + len(positions) - 1)
    assert np.abs(shown(obj) - positions[-1]).max() < 1e-5


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_new_recording_never_overwrites_an_earlier_one(
    bpy: ModuleType, scene: Any, ball: Add, tmp_path: Path
) -> None:
    obj, folder = ball(), tmp_path / "caches"
    bpy.ops.dimple.poke(record=True, **QUICK)
    assert cache_of(obj).filepath.endswith("untitled_Ball_take_001.pc2")
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    bpy.ops.dimple.poke(record=True, **{**QUICK, "depth_mm": 10.0})
    assert cache_of(obj).filepath.endswith("untitled_Ball_take_002.pc2")
    assert files(folder) == [f"untitled_Ball_take_00{n}.{end}" for n in (1, 2) for end in ("csv", "pc2")]
    assert all((folder / name).read_bytes() == data for name, data in first.items())


@pytest.mark.parametrize("kind", ["take", "bake"])
def test_a_second_file_without_a_name_leaves_the_first_ones_caches_alone(
    bpy: ModuleType, scene: Any, ball: Add, tmp_path: Path, kind: str
) -> None:
    folder = tmp_path / "caches"

    def animate() -> Any:
        obj = ball()
        bpy.context.scene.dimple.cache_dir = str(folder)
        if kind == "take":
            bpy.ops.dimple.poke(record=True, **QUICK)
        else:
            bpy.ops.dimple.bake(frame_start=1, frame_end=3)
        return obj

    animate()
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert cache_of(animate()).filepath.endswith(f"untitled_Ball_{kind}_002.pc2")
    assert len(files(folder)) == 4 and all((folder / name).read_bytes() == data for name, data in first.items())


def test_caches_of_a_file_without_a_name_outlive_the_extension(bpy: ModuleType, scene: Any, ball: Add) -> None:
    scene.dimple.cache_dir = ""
    obj = ball()
    bpy.ops.dimple.poke(record=True, **QUICK)
    path = Path(cache_of(obj).filepath)
    own = Path(bpy.utils.extension_path_user("bl_ext.user_default.dimple"))
    try:
        assert path.exists() and own not in path.parents, "Blender deletes that folder with the extension"
        assert Path(bpy.utils.user_resource("DATAFILES")) in path.parents
    finally:
        path.unlink()
        path.with_suffix(".csv").unlink()


def test_bodies_that_play_together_have_one_clock(
    bpy: ModuleType, scene: Any, ball: Add, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    for name in ("Slow", "Fast"):
        sessions.start(ball(name), bpy.context)
    slow, fast = sessions.sessions.values()
    begin = slow.session.begin
    monkeypatch.setattr(slow.session, "begin", lambda dt, **more: begin(min(dt, 0.003), **more))
    bpy.ops.dimple.record()
    for _ in range(60):
        live_step.advance(bpy.context, 1 / 60)
    assert slow.frame.time == pytest.approx(60 * 0.003, abs=2e-3)
    assert fast.frame.time == pytest.approx(slow.frame.time, abs=1 / 60), "the fast one waits"
    assert slow.recorder.frames == fast.recorder.frames > 3
    sessions.stop_all()


def test_the_end_of_a_recording_is_said_and_undo_takes_only_it_back(
    bpy: ModuleType, scene: Any, ball: Add
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    obj = ball()
    obj.location.x = 1.0
    scene.frame_end = 3
    bpy.ops.ed.undo_push(message="The artist's own move")
    bpy.ops.dimple.play(seconds=0.01)
    bpy.ops.dimple.record()
    bpy.ops.dimple.play(seconds=0.5)
    (sentence,) = sessions.stop_all()
    assert sentence.startswith('Recorded 13 frames of "Ball"') and "beyond the scene's last frame 3" in sentence
    assert obj.modifiers
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Ball"]
    assert not obj.modifiers and obj.location.x == 1.0
    bpy.ops.ed.redo()
    assert cache_of(bpy.data.objects["Ball"]).filepath.endswith("take_001.pc2")
