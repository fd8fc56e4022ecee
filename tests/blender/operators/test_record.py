"""What is pressed live can be recorded, and the object plays it."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

from tests.blender.operators.test_bake import cached

Add = Callable[..., Any]
Shown = Callable[[Any], np.ndarray]


def test_a_recorded_press_is_played_back(bpy: ModuleType, scene: Any, ball: Add, shown: Shown) -> None:
    obj = ball()
    rest = shown(obj).copy()
    scene.frame_set(10)
    bpy.ops.dimple.poke(record=True, press_s=0.25, hold_s=0.25, release_s=0.25)
    start, positions = cached(scene)
    assert start == 10 and len(positions) == 19
    assert obj.modifiers[0].frame_start == 10
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
    assert not obj.modifiers, "not while the session goes on"
    bpy.ops.dimple.reset()
    start, positions = cached(scene)
    assert (start, len(positions)) == (5, 1 + scene.render.fps // 4)
    assert np.abs(positions[0] - before).max() < 1e-6, "it begins with what showed"
    scene.frame_set(5 + len(positions) - 1)
    assert np.abs(shown(obj) - positions[-1]).max() < 1e-5
