"""The clock that live bodies and bakes share, so that a bake repeats its preview.

The scene is sampled at least 120 times per second of animation, so that a keyframed fingertip presses the same at 24
and at 120 frames per second; between two samples (looks) everything moves in a straight line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import bpy

from ...core.base import TICK

MOTION_HZ = 120  # [Hz] lowest sampling rate of keyframed motion


def frame_s(scene: bpy.types.Scene) -> float:
    """Return the duration of a frame [s]."""
    return scene.render.fps_base / scene.render.fps


def looks_a_frame(scene: bpy.types.Scene) -> int:
    """Return the number of samples of the scene per frame."""
    return math.ceil(MOTION_HZ * frame_s(scene) - 1e-9)


def look_s(scene: bpy.types.Scene) -> float:
    """Return the time between two samples of the scene [s]: a frame divided by a whole number."""
    return frame_s(scene) / looks_a_frame(scene)


def tick_s(scene: bpy.types.Scene) -> float:
    """Return the tick of a session of a scene [s]: at most a millisecond, and whole ticks between two samples.

    So at every frame a body is at the place of its object.
    """
    return look_s(scene) / math.ceil(look_s(scene) / TICK - 1e-9)


def looks(scene: bpy.types.Scene, frame: int) -> Iterator[float]:
    """Advance the scene from the previous frame to this one; yield at each sample the time since the last [s]."""
    count = looks_a_frame(scene)
    for look in range(1, count + 1):
        at = frame - 1 + look / count
        scene.frame_set(math.floor(at), subframe=at - math.floor(at))
        yield look_s(scene)


def is_playing(context: bpy.types.Context) -> bool:
    """Return whether Blender plays the timeline."""
    return bool(context.screen and context.screen.is_animation_playing)
