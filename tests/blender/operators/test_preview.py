"""A bake is what the preview has shown: live and simulated again, bit for bit."""

import hashlib
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.conftest import icosphere
from tests.point_cache import cache_of, read_point_cache

FRAMES = 14


@pytest.fixture
def swinging(pressed: Callable[..., Any]) -> Callable[[float], Any]:
    """Return a function that adds a pressed ball that is carried and turned meanwhile, eased as Blender keys it."""

    def set_up(fps: int) -> Any:
        obj = pressed(fps)
        icosphere(obj.data, 4)
        for frame, x in ((1, 0.0), (1 + fps // 4, 0.3), (1 + fps // 2, -0.1)):
            obj.location.x = obj.rotation_euler.y = x
            obj.keyframe_insert("location", index=0, frame=frame)
            obj.keyframe_insert("rotation_euler", index=1, frame=frame)
        return obj

    return set_up


def hashed(samples: Any) -> str:
    return hashlib.sha256(np.ascontiguousarray(samples, "<f4").tobytes()).hexdigest()


def samples(path: str) -> np.ndarray:
    return read_point_cache(path)[2]


@pytest.mark.parametrize(("fps", "setting"), [(24, "MESH"), (25, "PROXY"), (60, "MESH")])
def test_live_and_simulated_again_are_the_same_bits(
    bpy: ModuleType, scene: Any, swinging: Callable[[float], Any], fps: int, setting: str, simulated: Any, shown: Any
) -> None:
    obj = swinging(fps)
    scene.frame_set(1)
    obj.dimple.simulated, obj.dimple.proxy_vertices = setting, 100
    rest = shown(obj)
    bpy.ops.dimple.play(seconds=0)
    live = [simulated(obj)]
    for _ in range(FRAMES):
        bpy.ops.dimple.play(frames=1)
        live.append(simulated(obj))
        assert np.abs(shown(obj) - rest - live[-1]).max() < 1e-6
    bpy.ops.dimple.reset()
    assert scene.frame_current == 1 + FRAMES
    assert np.abs(np.array(live) - live[0]).max() > 0.05
    bpy.ops.dimple.bake(frame_start=1, frame_end=1 + FRAMES)
    assert hashed(samples(cache_of(obj).filepath)) == hashed(np.array(live)), "baked as shown"


def test_play_follows_the_timeline_and_begins_anew_where_it_is_wound_back(
    bpy: ModuleType, scene: Any, swinging: Callable[[float], Any], hand: Any, monkeypatch: Any, simulated: Any
) -> None:
    from bl_ext.user_default.dimple.operators.bridge import timeline

    monkeypatch.setattr(timeline, "is_playing", lambda _context: True)
    obj = swinging(24)
    obj.dimple.simulated = "MESH"
    scene.frame_set(1)
    bpy.ops.dimple.bake(frame_start=1, frame_end=6)
    baked = samples(cache_of(obj).filepath)
    scene.frame_set(1)
    play = hand("play")
    play.invoke()
    for _ in range(2):
        play.ticks(1)
        for frame in (2, 3, 9, 9, 9):  # Blender plays, and drops frames where we are slow
            scene.frame_set(frame)
            play.ticks(1)
        assert scene.frame_current == 6, "the timeline waits"
        assert hashed(simulated(obj)) == hashed(baked[5])
        scene.frame_set(1)
        play.ticks(1)
        assert hashed(simulated(obj)) == hashed(baked[0])
    play.send("ESC")
