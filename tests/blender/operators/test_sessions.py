"""Nothing that happens to Blender while a body is pressed leaves a trace: undo, save, load, delete, edit."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
Shown = Callable[[Any], np.ndarray]


@pytest.fixture
def sessions(bpy: ModuleType) -> Any:
    """The running sessions; after the test nothing may be left of them."""
    from bl_ext.user_default.dimple.operators import sessions

    yield sessions
    assert not sessions.sessions and not sessions.runs
    assert bpy.context.window_manager.dimple.state == ""


@pytest.fixture
def playing(bpy: ModuleType, ball: Add) -> Callable[..., Any]:
    """Return a function that adds a ball and lets it hang from its base in gravity until it is out of shape."""

    def play(keys: bool = False) -> Any:
        obj = ball()
        if keys:
            obj.shape_key_add(name="Basis")
            obj.shape_key_add(name="Other").value = 0.5
        bpy.context.scene.dimple.use_gravity = True
        bpy.ops.ed.undo_push(message="Before")
        bpy.ops.dimple.play(seconds=0.05)
        return obj

    return play


def is_clean(obj: Any) -> bool:
    keys = obj.data.shape_keys
    return ".dimple_rest" not in obj.data.attributes and not (keys and "Dimple" in keys.key_blocks)


@pytest.fixture
def rest(bpy: ModuleType, ball: Add, coordinates: Bits) -> bytes:
    """The coordinates of the ball as it is made."""
    obj = ball("Rest")
    bits = coordinates(obj)
    bpy.data.objects.remove(obj)
    return bits


@pytest.mark.parametrize("keys", [False, True])
def test_reset_puts_every_bit_back(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, shown: Shown, rest: bytes, keys: bool
) -> None:
    obj = playing(keys)
    assert shown(obj).tobytes() != rest
    bpy.ops.dimple.reset()
    assert is_clean(obj) and coordinates(obj) == rest == shown(obj).tobytes()
    for key in obj.data.shape_keys.key_blocks if keys else ():
        assert np.array([point.co for point in key.data], np.float32).tobytes() == rest


def test_loading_a_file_ends_the_session(bpy: ModuleType, sessions: Any, playing: Any) -> None:
    playing()
    assert sessions.sessions
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.mark.parametrize("keys", [False, True])
def test_a_file_saved_while_playing_holds_the_rest_shape(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, tmp_path: Path, keys: bool
) -> None:
    obj = playing(keys)
    shown = coordinates(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pressed.blend"))
    assert sessions.sessions and coordinates(obj) == shown, "the session goes on"
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pressed.blend"))
    obj = bpy.data.objects["Ball"]
    assert is_clean(obj) and coordinates(obj) == rest


def test_a_file_saved_while_playing_holds_shared_meshes_and_bakes_as_they_were(
    bpy: ModuleType, sessions: Any, ball: Add, coordinates: Bits, rest: bytes, tmp_path: Path
) -> None:
    obj = ball()
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    twin.select_set(False)
    bpy.context.scene.dimple.cache_dir = str(tmp_path)
    bpy.ops.dimple.bake(frame_start=1, frame_end=2)
    bpy.context.scene.dimple.use_gravity = True
    bpy.ops.dimple.play(seconds=0.05)
    assert not obj.modifiers["Dimple"].show_viewport
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pressed.blend"))
    assert coordinates(obj) != rest and obj.data != twin.data and not obj.modifiers["Dimple"].show_viewport
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pressed.blend"))
    obj, twin = bpy.data.objects["Ball"], bpy.data.objects["Ball.001"]
    assert obj.data == twin.data and coordinates(obj) == rest and is_clean(obj)
    assert obj.modifiers["Dimple"].show_viewport


def test_a_file_written_behind_our_back_is_put_right_on_loading(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, tmp_path: Path
) -> None:
    """An autosave asks nobody."""
    obj = playing()
    assert coordinates(obj) != rest
    bpy.data.libraries.write(str(tmp_path / "auto.blend"), {obj})
    bpy.ops.dimple.reset()
    bpy.data.objects.remove(obj)
    with bpy.data.libraries.load(str(tmp_path / "auto.blend")) as (_, wanted):
        wanted.objects = ["Ball"]
    bpy.context.collection.objects.link(wanted.objects[0])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    obj = bpy.data.objects["Ball"]
    assert is_clean(obj) and coordinates(obj) == rest


def test_an_object_deleted_while_playing_ends_its_session_only(
    bpy: ModuleType, sessions: Any, ball: Add, playing: Any
) -> None:
    playing()
    other = ball("Other")
    bpy.ops.dimple.play(seconds=0.02)
    assert len(sessions.sessions) == 2
    bpy.data.objects.remove(bpy.data.objects["Ball"])
    bpy.ops.dimple.play(seconds=0.02)
    assert list(sessions.sessions) == [other.session_uid]
    bpy.ops.dimple.reset()
    assert is_clean(other)


def test_an_object_taken_out_of_the_scene_is_put_back_to_rest(
    bpy: ModuleType, sessions: Any, ball: Add, playing: Any, coordinates: Bits, rest: bytes
) -> None:
    obj = playing()
    bpy.context.collection.objects.unlink(obj)
    ball("Other")
    bpy.ops.dimple.play(seconds=0.02)
    assert coordinates(obj) == rest and obj.session_uid not in sessions.sessions
    bpy.ops.dimple.reset()


@pytest.mark.parametrize("keys", [False, True])
def test_undo_while_playing_goes_on_and_leaves_no_trace(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, keys: bool
) -> None:
    playing(keys)
    lamp = bpy.data.objects.new("Lamp", None)
    bpy.context.collection.objects.link(lamp)
    bpy.ops.ed.undo_push(message="A lamp, while the ball is out of shape")
    bpy.ops.dimple.play(seconds=0.02)
    bpy.ops.ed.undo()
    assert "Lamp" not in bpy.data.objects and len(sessions.sessions) == 1
    bpy.ops.dimple.play(seconds=0.02)
    bpy.ops.ed.redo()
    bpy.ops.dimple.play(seconds=0.02)
    obj = bpy.data.objects["Ball"]
    assert keys or coordinates(obj) != rest
    bpy.ops.dimple.reset()
    assert is_clean(bpy.data.objects["Ball"]) and coordinates(bpy.data.objects["Ball"]) == rest


@pytest.mark.parametrize("keys", [False, True])
def test_undo_back_into_a_session_that_has_ended_shows_the_rest_shape(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, keys: bool
) -> None:
    playing(keys)
    bpy.ops.ed.undo_push(message="Something, while the ball is out of shape")
    bpy.ops.dimple.reset()
    bpy.ops.ed.undo_push(message="Reset")
    for step in (bpy.ops.ed.undo, bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.redo, bpy.ops.ed.undo):
        step()
        obj = bpy.data.objects["Ball"]
        assert is_clean(obj) and coordinates(obj) == rest


def test_undo_of_the_body_itself_ends_its_session(bpy: ModuleType, sessions: Any, ball: Add) -> None:
    bpy.ops.ed.undo_push(message="Empty")
    ball()
    bpy.ops.ed.undo_push(message="Ball")
    bpy.ops.dimple.play(seconds=0.02)
    bpy.ops.ed.undo()
    assert "Ball" not in bpy.data.objects and not sessions.sessions


def test_a_kept_poke_is_undone_bit_for_bit(
    bpy: ModuleType, sessions: Any, ball: Add, coordinates: Bits, rest: bytes
) -> None:
    ball()
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.dimple.poke(press_s=0.05, hold_s=0, release_s=0, keep=True)
    bpy.ops.ed.undo_push(message="Poke")
    kept = coordinates(bpy.data.objects["Ball"])
    assert kept != rest
    bpy.ops.ed.undo()
    assert coordinates(bpy.data.objects["Ball"]) == rest and is_clean(bpy.data.objects["Ball"])
    bpy.ops.ed.redo()
    assert coordinates(bpy.data.objects["Ball"]) == kept and is_clean(bpy.data.objects["Ball"])


@pytest.mark.parametrize("undos", [1, 2, 3])
def test_undo_leaves_duplicates_with_a_mesh_that_is_there(
    bpy: ModuleType, sessions: Any, ball: Add, coordinates: Bits, rest: bytes, undos: int
) -> None:
    """A step that does not know of the copy would give the object a mesh that is gone, and Blender crashed."""
    obj = ball()
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    twin.select_set(False)
    bpy.context.scene.dimple.use_gravity = True
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.ed.undo_push(message="Nothing")
    bpy.ops.dimple.play(seconds=0.05)
    bpy.ops.ed.undo_push(message="Something, meanwhile")
    for _ in range(undos):
        bpy.ops.ed.undo()
    obj, twin = bpy.data.objects["Ball"], bpy.data.objects["Ball.001"]
    assert coordinates(twin) == rest and is_clean(twin)
    assert bool(sessions.sessions) == (undos == 1), "undone past its start a session ends"
    assert (obj.data == twin.data) == (undos > 1)
    for _ in range(undos):
        bpy.ops.ed.redo()
    obj = bpy.data.objects["Ball"]
    bpy.ops.dimple.play(seconds=0.05)
    assert coordinates(obj) != rest
    bpy.ops.dimple.reset()
    assert coordinates(obj) == rest == coordinates(bpy.data.objects["Ball.001"]) and is_clean(obj)


@pytest.mark.parametrize("keys", [False, True])
def test_edit_mode_while_playing_ends_the_session_with_the_rest_shape(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, keys: bool
) -> None:
    from bl_ext.user_default.dimple.operators import live

    obj = playing(keys)
    bpy.ops.object.mode_set(mode="EDIT")
    said = live.advance(bpy.context, 0.01)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "edited" in said[0] and not sessions.sessions
    assert coordinates(obj) == rest and is_clean(obj)


def test_changing_the_mesh_while_playing_ends_the_session(bpy: ModuleType, sessions: Any, playing: Any) -> None:
    from bl_ext.user_default.dimple.operators import live

    obj = playing()
    obj.data.clear_geometry()
    assert "edited" in live.advance(bpy.context, 0.01)[0]
    assert not sessions.sessions


def test_scaling_to_zero_while_playing_ends_the_session(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes
) -> None:
    from bl_ext.user_default.dimple.operators import live

    obj = playing()
    obj.scale.x = 0
    bpy.context.view_layer.update()
    assert "scale of 0" in live.advance(bpy.context, 0.01)[0]
    assert coordinates(obj) == rest


def test_switching_the_extension_off_ends_everything(
    bpy: ModuleType, playing: Any, coordinates: Bits, rest: bytes
) -> None:
    obj = playing()
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.dimple")
    try:
        assert coordinates(obj) == rest and is_clean(obj)
        names = ("load_pre", "load_post", "save_pre", "save_post", "save_post_fail", "undo_post", "redo_post")
        handlers = [each for name in names for each in getattr(bpy.app.handlers, name)]
        assert not [each for each in handlers if "dimple" in each.__module__]
    finally:
        bpy.ops.preferences.addon_enable(module="bl_ext.user_default.dimple")


def test_something_unforeseen_ends_everything_and_is_not_swallowed(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    obj = playing()

    def broken(*_: Any, **__: Any) -> None:
        raise ZeroDivisionError("unforeseen")

    monkeypatch.setattr(next(iter(sessions.sessions.values())).session, "step", broken)
    with pytest.raises(RuntimeError, match="unforeseen"):
        bpy.ops.dimple.play(seconds=0.02)
    assert coordinates(obj) == rest and is_clean(obj)


def test_a_body_keeps_its_session_when_it_is_renamed(bpy: ModuleType, sessions: Any, playing: Any) -> None:
    obj = playing()
    obj.name = "Another"
    before = sessions.get(obj).frame.time
    bpy.ops.dimple.play(seconds=0.02)
    assert sessions.get(obj).frame.time > before
    bpy.ops.dimple.reset()
    assert is_clean(obj)


CLOSED_WHILE_PLAYING = """
import bpy
bpy.ops.preferences.addon_enable(module="bl_ext.user_default.dimple")
bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
bpy.context.scene.dimple.use_gravity = True
assert bpy.ops.dimple.play(seconds=0.02) == {"FINISHED"}
print("playing at the end")
"""


def test_closing_blender_while_playing_is_no_error(bpy: ModuleType) -> None:
    run = subprocess.run(
        [sys.executable, "-c", CLOSED_WHILE_PLAYING], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0 and "playing at the end" in run.stdout, run.stdout + run.stderr
    assert "Traceback" not in run.stdout + run.stderr
