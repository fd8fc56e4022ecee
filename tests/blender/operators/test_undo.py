"""Undo while a body is pressed, and after it: no step holds a pressed shape, and none is lost."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_sessions import is_clean

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
Shown = Callable[[Any], np.ndarray]


@pytest.mark.parametrize("keys", [False, True])
def test_undo_while_playing_goes_on_and_leaves_no_trace(
    bpy: ModuleType, sessions: Any, playing: Any, coordinates: Bits, shown: Shown, rest: bytes, keys: bool
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
    assert shown(obj).tobytes() != rest == coordinates(obj)
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
    bpy: ModuleType, sessions: Any, ball: Add, coordinates: Bits, shown: Any, rest: bytes
) -> None:
    ball()
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.dimple.poke(press_s=0.05, hold_s=0, release_s=0, keep=True)
    bpy.ops.ed.undo_push(message="Poke")
    kept = shown(bpy.data.objects["Ball"]).tobytes()
    assert kept != rest
    bpy.ops.ed.undo()
    assert shown(bpy.data.objects["Ball"]).tobytes() == rest and is_clean(bpy.data.objects["Ball"])
    bpy.ops.ed.redo()
    assert shown(bpy.data.objects["Ball"]).tobytes() == kept
    assert coordinates(bpy.data.objects["Ball"]) == rest and is_clean(bpy.data.objects["Ball"])


@pytest.mark.parametrize("undos", [1, 2])
def test_undo_past_the_start_of_a_session_leaves_duplicates_their_mesh(
    bpy: ModuleType, sessions: Any, ball: Add, coordinates: Bits, shown: Shown, rest: bytes, undos: int
) -> None:
    """A step that does not know of the modifier would leave an object with a node group that is gone: Blender ended."""
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
    assert coordinates(twin) == rest and not twin.modifiers
    assert sessions.sessions and obj.data == twin.data and shown(twin).tobytes() == rest
    for _ in range(undos):
        bpy.ops.ed.redo()
    obj = bpy.data.objects["Ball"]
    bpy.ops.dimple.play(seconds=0.05)
    assert shown(obj).tobytes() != rest
    bpy.ops.dimple.reset()
    assert coordinates(obj) == rest == coordinates(bpy.data.objects["Ball.001"]) and is_clean(obj)
