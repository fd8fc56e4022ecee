"""Nothing that happens to Blender while a body is pressed leaves a trace: save, load, delete, edit."""

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


def is_clean(obj: Any) -> bool:
    """Tell whether nothing of a running press is left: on the object, on its mesh, in the file.

    A kept press and a bake leave a modifier, with a group and carriers that nothing else uses.
    """
    import bpy

    keys, kept = obj.data.shape_keys, bool({"Pressed", "Dimple"} & {each.name for each in obj.modifiers})
    left = [each for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.node_groups) for each in kind]
    carriers = [each for each in bpy.data.objects if each.name.startswith(".Dimple")]
    return (
        not any(each.name.startswith(".Dimple Press" if kept else ".Dimple") for each in left)
        and not any(each.users_collection or each.users != 1 for each in carriers)
        and not any(each.name.startswith("Dimple Press") for each in obj.modifiers)
        and not any(each.name.startswith(".dimple") for each in obj.data.attributes)
        and not (keys and "Dimple" in keys.key_blocks)
    )


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


@pytest.mark.parametrize("keys", [False, True])
def test_a_file_saved_while_playing_holds_the_rest_shape(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, shown: Shown, rest: bytes, tmp_path: Path,
    keys: bool,
) -> None:
    obj = playing(keys)
    before = shown(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pressed.blend"), copy=True)
    assert sessions.sessions and np.array_equal(shown(obj), before) and before.tobytes() != rest, "the session goes on"
    with bpy.data.libraries.load(str(tmp_path / "pressed.blend")) as (held, _):
        assert "Ball" in held.objects and not [name for name in held.objects if name.startswith(".Dimple")]
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pressed.blend"))
    obj = bpy.data.objects["Ball"]
    assert is_clean(obj) and coordinates(obj) == rest


def test_a_file_saved_while_playing_holds_shared_meshes_and_bakes_as_they_were(
    bpy: ModuleType, sessions: Any, ball: Add, coordinates: Bits, shown: Shown, rest: bytes, tmp_path: Path
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
    assert shown(obj).tobytes() != rest and obj.data == twin.data and not obj.modifiers["Dimple"].show_viewport
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pressed.blend"))
    obj, twin = bpy.data.objects["Ball"], bpy.data.objects["Ball.001"]
    assert obj.data == twin.data and coordinates(obj) == rest and is_clean(obj)
    assert obj.modifiers["Dimple"].show_viewport


def test_a_file_written_behind_our_back_is_put_right_on_loading(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, shown: Shown, rest: bytes, tmp_path: Path
) -> None:
    """An autosave asks nobody."""
    obj = playing()
    assert shown(obj).tobytes() != rest == coordinates(obj)
    bpy.data.libraries.write(str(tmp_path / "auto.blend"), {obj})
    bpy.ops.dimple.reset()
    bpy.data.objects.remove(obj)
    with bpy.data.libraries.load(str(tmp_path / "auto.blend")) as (_, wanted):
        wanted.objects = ["Ball"]
    bpy.context.collection.objects.link(wanted.objects[0])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    obj = bpy.data.objects["Ball"]
    assert is_clean(obj) and coordinates(obj) == rest == shown(obj).tobytes()


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
def test_edit_mode_while_playing_ends_the_session_with_the_rest_shape(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, keys: bool
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    obj = playing(keys)
    bpy.ops.object.mode_set(mode="EDIT")
    said = live_step.advance(bpy.context, 0.01)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "edited" in said[0] and not sessions.sessions
    assert coordinates(obj) == rest and is_clean(obj)


def test_changing_the_mesh_while_playing_ends_the_session(bpy: ModuleType, sessions: Any, playing: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    obj = playing()
    obj.data.clear_geometry()
    assert "edited" in live_step.advance(bpy.context, 0.01)[0]
    assert not sessions.sessions


def test_scaling_to_zero_while_playing_ends_the_session(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    obj = playing()
    obj.scale.x = 0
    bpy.context.view_layer.update()
    assert "scale of 0" in live_step.advance(bpy.context, 0.01)[0]
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
