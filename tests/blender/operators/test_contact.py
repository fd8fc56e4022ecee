"""Objects with Dimple Collider ticked are met by running bodies, in play and in a bake alike."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Add = Callable[..., Any]
Shown = Callable[[Any], np.ndarray]


@pytest.fixture
def pushed(bpy: ModuleType, scene: Any, ball: Add, add: Add) -> Callable[[], tuple[Any, Any]]:
    """Return a function that adds a soft ball and a cube that is keyframed to go a quarter of the way into it."""

    def make() -> tuple[Any, Any]:
        obj, cube = ball(), add(name="Pusher")
        cube.location = (0, 0, 2.1)
        cube.scale = (0.8, 0.8, 1)
        cube.keyframe_insert("location", frame=1)
        cube.location = (0, 0, 1.5)
        cube.keyframe_insert("location", frame=7)
        cube.dimple.collider = True
        cube.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        obj.dimple.pinned = "BASE"
        scene.dimple.use_gravity = scene.dimple.use_ground = False
        scene.frame_set(1)
        return obj, cube

    return make


def top(points: np.ndarray) -> float:
    middle = np.hypot(points[:, 0], points[:, 1]) < 0.6
    return float(points[middle][:, 2].max())


def test_a_keyframed_cube_pushes_a_soft_ball_and_a_bake_equals_play(
    bpy: ModuleType, scene: Any, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes]
) -> None:
    from bl_ext.user_default.dimple.core.recording import read_point_cache

    obj, _ = pushed()
    before = coordinates(obj)
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=8) == {"FINISHED"}
    assert coordinates(obj) == before
    (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
    baked = read_point_cache(path)[2]
    assert top(baked[-1]) < 0.5 < 0.9 < top(baked[0])
    bpy.ops.dimple.unbake()
    scene.frame_set(1)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    shown = np.frombuffer(coordinates(obj), np.float32).reshape(-1, 3)
    assert np.abs(shown - baked[-1]).max() < 1e-5
    bpy.ops.dimple.reset()
    assert coordinates(obj) == before


def test_without_the_tick_the_cube_goes_through(
    bpy: ModuleType, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes]
) -> None:
    obj, cube = pushed()
    cube.dimple.collider = False
    before = coordinates(obj)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    assert coordinates(obj) == before


def test_what_intersects_at_the_start_is_refused_and_nothing_is_changed(
    bpy: ModuleType, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes]
) -> None:
    obj, cube = pushed()
    cube.animation_data_clear()
    cube.location = (0, 0, 1.5)
    before = coordinates(obj)
    with pytest.raises(RuntimeError, match='"Ball" and "Pusher" intersect at'):
        bpy.ops.dimple.play(seconds=0.1)
    assert coordinates(obj) == before


def test_a_body_that_is_to_be_moved_apart_plays_where_it_would_be_refused(
    bpy: ModuleType, scene: Any, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes]
) -> None:
    obj, cube = pushed()
    cube.animation_data_clear()
    cube.location = (0, 0, 1.9)
    obj.dimple.pinned, obj.dimple.move_apart = "NONE", True
    before = coordinates(obj)
    assert bpy.ops.dimple.play(seconds=0.1) == {"FINISHED"}
    shown = np.frombuffer(coordinates(obj), np.float32).reshape(-1, 3)
    assert shown[:, 2].max() < 0.91
    bpy.ops.dimple.reset()
    assert coordinates(obj) == before


def test_two_bodies_press_each_other_flat_where_they_meet(
    bpy: ModuleType, scene: Any, ball: Add, add: Add, coordinates: Callable[[Any], bytes]
) -> None:
    lower, upper = ball("Lower"), ball("Upper")
    upper.location = (0.02, 0, 2.05)
    floor = add([(-3, -3, -1.05), (3, -3, -1.05), (3, 3, -1.05), (-3, 3, -1.05)], [(0, 1, 2, 3)], name="Floor")
    floor.dimple.collider = True
    floor.select_set(False)
    for obj in (lower, upper):
        obj.dimple.pinned = "NONE"
        obj.select_set(True)
    scene.dimple.use_gravity, scene.dimple.use_ground = True, False
    assert bpy.ops.dimple.play(seconds=0.3) == {"FINISHED"}
    low, high = (np.frombuffer(coordinates(obj), np.float32).reshape(-1, 3) for obj in (lower, upper))
    assert -1.05 < low[:, 2].min() < -0.99
    middle = np.hypot(low[:, 0], low[:, 1]) < 0.3
    assert 0 < (high[:, 2] + 2.05).min() - low[middle][:, 2].max() < 0.1
    bpy.ops.dimple.reset()
