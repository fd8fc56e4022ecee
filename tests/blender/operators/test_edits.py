"""What the artist changes while a body is live stays changed, and nothing of the press stays with it."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_sessions import is_clean

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
Shown = Callable[[Any], np.ndarray]


def points(obj: Any) -> np.ndarray:
    numbers = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", numbers)
    return numbers.reshape(-1, 3)


def in_world(obj: Any) -> np.ndarray:
    matrix = np.array(obj.matrix_world)
    return points(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def advance(bpy: ModuleType) -> list[str]:
    from bl_ext.user_default.dimple.operators.press import live_step

    return live_step.advance(bpy.context, 0.02)


def exits(bpy: ModuleType) -> dict[str, Callable[[], Any]]:
    """Return how a session can end after an edit: at the next step, at once, while paused, with the file saved."""
    from bl_ext.user_default.dimple.operators.press import showing

    return {"step": lambda: advance(bpy), "reset": bpy.ops.dimple.reset, "paused": showing.end_changed}


@pytest.mark.parametrize(
    ("applied", "keys", "end"),
    [
        ({"scale": True}, False, "step"), ({"location": True}, True, "reset"), ({"rotation": True}, False, "paused"),
        ({"scale": True, "location": True}, True, "step"),
    ],
)  # fmt: skip
def test_a_transform_applied_while_live_leaves_the_rest_shape_where_it_was_in_the_world(
    bpy: ModuleType, sessions: Any, ball: Add, applied: dict[str, bool], keys: bool, end: str
) -> None:
    obj = ball()
    if keys:
        obj.shape_key_add(name="Basis")
        obj.shape_key_add(name="Other")
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.1, 0.2, 0.3), (2, 1, 0.5)
    bpy.context.view_layer.update()
    rest = in_world(obj)
    bpy.context.scene.dimple.use_gravity = True
    bpy.ops.dimple.play(seconds=0.05)
    bpy.ops.object.transform_apply(
        **{"location": False, "rotation": False, "scale": False, "properties": False, **applied}
    )
    bpy.context.view_layer.update()
    exits(bpy)[end]()
    bpy.context.view_layer.update()
    assert bool(sessions.sessions) == (keys and end != "reset"), "with keys its shape at rest is read at every step"
    if sessions.sessions:
        bpy.ops.dimple.reset()
    assert is_clean(obj)
    assert np.abs(in_world(obj) - rest).max() < 1e-5
    assert "scale" not in applied or tuple(obj.scale) == (1, 1, 1)
    for key in obj.data.shape_keys.key_blocks if keys else ():
        assert np.array_equal(np.array([point.co for point in key.points], np.float32), points(obj))


def test_an_edit_is_said_in_a_sentence(bpy: ModuleType, sessions: Any, playing: Any) -> None:
    obj = playing()
    obj.data.vertices[0].co.x += 1
    assert advance(bpy)[0] == '"Ball" was edited while it was pressed, so its session has ended. The edit is kept.'


@pytest.mark.parametrize("end", ["step", "reset", "paused"])
def test_vertices_that_a_script_moves_while_live_stay_moved_and_the_others_go_back(
    bpy: ModuleType, sessions: Any, playing: Any, rest: bytes, end: str
) -> None:
    obj = playing()
    obj.data.vertices[7].co.x += 0.5
    exits(bpy)[end]()
    moved = points(obj) - np.frombuffer(rest, np.float32).reshape(-1, 3)
    assert not sessions.sessions and is_clean(obj)
    assert moved[7] == pytest.approx((0.5, 0, 0), abs=1e-6)
    assert not np.delete(moved, 7, axis=0).any()


def test_an_edit_made_before_a_save_is_in_the_file(
    bpy: ModuleType, sessions: Any, playing: Any, rest: bytes, tmp_path: Any
) -> None:
    playing().data.vertices[7].co.x += 0.5
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "edited.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "edited.blend"))
    obj = bpy.data.objects["Ball"]
    moved = points(obj) - np.frombuffer(rest, np.float32).reshape(-1, 3)
    assert is_clean(obj) and moved[7, 0] == pytest.approx(0.5, abs=1e-6) and not np.delete(moved, 7, axis=0).any()


def test_a_body_that_is_given_another_mesh_while_live_keeps_it_as_it_is(
    bpy: ModuleType, sessions: Any, playing: Any, ball: Add, coordinates: Bits, rest: bytes
) -> None:
    obj = playing()
    first, other = obj.data, ball("Other")
    other.data.vertices[3].co.z = 5
    before = coordinates(other)
    obj.data = other.data
    advance(bpy)
    assert not sessions.sessions and coordinates(other) == before
    assert ".dimple_rest" not in first.attributes
    obj.data = first
    assert coordinates(obj) == rest


@pytest.mark.parametrize("stepped", [False, True])
def test_shape_keys_added_while_live_are_at_rest_after_it(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, shown: Shown, rest: bytes, stepped: bool
) -> None:
    obj = playing()
    out_of_shape = np.abs(shown(obj) - np.frombuffer(rest, np.float32).reshape(-1, 3)).max()
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Nose", from_mix=False)
    key.value = 0.0
    key.points[7].co.x += 0.5
    if stepped:
        assert advance(bpy) == [] and sessions.sessions
        off = np.abs(shown(obj) - sessions.get(obj).rest)
        assert out_of_shape / 2 < off.max() < 3 * out_of_shape, "the session shows, and once only"
    bpy.ops.dimple.reset()
    assert is_clean(obj) and coordinates(obj) == rest
    basis, nose = (
        np.array([point.co for point in obj.data.shape_keys.key_blocks[name].points], np.float32)
        for name in ("Basis", "Nose")
    )
    assert basis.tobytes() == rest
    assert np.abs((nose - basis)[7] - (0.5, 0, 0)).max() < 1e-6 and not np.delete(nose - basis, 7, axis=0).any()


def test_a_vertex_moved_in_edit_mode_before_anybody_looked_stays_moved(
    bpy: ModuleType, sessions: Any, playing: Any, rest: bytes
) -> None:
    import bmesh

    obj = playing()
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(obj.data)
    edited.verts.ensure_lookup_table()
    edited.verts[7].co.x += 0.5
    exits(bpy)["paused"]()
    bpy.ops.object.mode_set(mode="OBJECT")
    moved = points(obj) - np.frombuffer(rest, np.float32).reshape(-1, 3)
    assert moved[7, 0] == pytest.approx(0.5, abs=1e-6) and not np.delete(moved, 7, axis=0).any()


def duplicate(bpy: ModuleType, obj: Any, linked: bool) -> Any:
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.object.duplicate(linked=linked)
    return bpy.context.object


@pytest.mark.parametrize(("linked", "keys", "keep"), [(False, True, True), (True, False, False)])
def test_a_duplicate_made_while_live_is_at_rest_once_the_session_has_ended(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes, linked: bool, keys: bool, keep: bool
) -> None:
    obj = playing(keys)
    twin = duplicate(bpy, obj, linked)
    sessions.stop_all(restore=not keep)
    assert not twin.modifiers and coordinates(twin) == rest
    assert is_clean(obj) and coordinates(obj) == rest and bool(obj.modifiers) == keep


def test_a_duplicate_made_while_live_is_at_rest_at_the_next_step_and_its_edits_stay(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, shown: Shown, rest: bytes
) -> None:
    twin = duplicate(bpy, playing(), False)
    assert shown(twin).tobytes() != rest
    advance(bpy)
    assert not twin.modifiers and shown(twin).tobytes() == rest and sessions.sessions
    twin.data.vertices[7].co.x += 0.5
    edited = coordinates(twin)
    bpy.ops.dimple.reset()
    assert coordinates(twin) == edited


@pytest.mark.parametrize("linked", [False, True])
def test_a_duplicate_made_while_live_plays_its_bake(
    bpy: ModuleType, sessions: Any, scene: Any, ball: Add, linked: bool
) -> None:
    obj = ball()
    bpy.ops.dimple.bake(frame_start=1, frame_end=2)
    bpy.ops.dimple.play(seconds=0.02)
    assert not obj.modifiers["Dimple"].show_viewport
    twin = duplicate(bpy, obj, linked)
    bpy.ops.dimple.reset()
    for each in (obj, twin):
        assert each.modifiers["Dimple"].show_viewport and "dimple_caches_off" not in each


def test_an_edit_that_was_undone_is_not_taken_for_a_new_one(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, rest: bytes
) -> None:
    obj = playing()
    bpy.ops.ed.undo_push(message="While it is out of shape")
    obj.data.vertices[7].co.x += 0.5
    advance(bpy)
    bpy.ops.ed.undo_push(message="Edited")
    edited = coordinates(obj)
    bpy.ops.dimple.play(seconds=0.05)
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Ball"]
    assert not sessions.sessions, "its session began with another rest shape"
    assert coordinates(obj) == rest and is_clean(obj)
    bpy.ops.ed.redo()
    assert coordinates(bpy.data.objects["Ball"]) == edited


def test_what_carries_a_press_is_deleted_and_the_session_goes_on(
    bpy: ModuleType, sessions: Any, playing: Any, rest: bytes, shown: Shown
) -> None:
    obj = playing()
    bpy.data.objects.remove(bpy.data.objects[".Dimple Carrier"])
    bpy.ops.dimple.play(seconds=0.05)
    assert shown(obj).tobytes() != rest and sessions.sessions
    bpy.ops.dimple.reset()
    assert shown(obj).tobytes() == rest and is_clean(obj)


@pytest.mark.parametrize("how", ["paste", "scene", "paste after it", "kept"])
def test_a_copy_of_a_live_body_leaves_nothing_of_ours_in_a_saved_file(
    bpy: ModuleType, sessions: Any, playing: Any, tmp_path: Path, how: str
) -> None:
    playing()
    if how == "scene":
        bpy.ops.scene.new(type="FULL_COPY")
    else:
        if how == "kept":
            sessions.stop_all(restore=False)
        bpy.ops.view3d.copybuffer()
        if how == "paste after it":
            bpy.ops.dimple.reset()
        bpy.ops.view3d.pastebuffer()
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    sessions.stop_all()
    bpy.ops.wm.open_mainfile(filepath=path)
    data = (*bpy.data.objects, *bpy.data.meshes, *bpy.data.node_groups)
    ours = [each for each in data if each.name.startswith(".Dimple")]
    carriers = [each for each in ours if isinstance(each, bpy.types.Object)]
    assert not any(each.users_collection for each in carriers), "none of them is in a scene"
    assert len(ours) == (2 * 3 if how == "kept" else 0), "a group, a carrier and its mesh"


def test_over_a_hidden_body_nothing_is_drawn(
    bpy: ModuleType, sessions: Any, playing: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import canvas, overlay

    obj = playing()
    monkeypatch.setattr(canvas, "overlays_shown", lambda _: True)
    for hidden in (False, True):
        obj.hide_set(hidden)
        assert bool(overlay.shown_bodies(bpy.context)) is not hidden
    sessions.stop_all()
