"""The clock that a live body and a bake share, so that a bake repeats its preview.

The scene is looked at 120 times a second of animation or more often, so that a keyframed fingertip presses the same
at 24 and at 120 frames a second; between two looks everything moves in a straight line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import bpy

from ...core.base import TICK

MOTION_HZ = 120  # how often keyframed motion is looked at


def frame_s(scene: bpy.types.Scene) -> float:
    """Return the time of a frame [s]."""
    return scene.render.fps_base / scene.render.fps


def looks_a_frame(scene: bpy.types.Scene) -> int:
    """Return how often the scene is looked at in each frame."""
    return math.ceil(MOTION_HZ * frame_s(scene) - 1e-9)


def look_s(scene: bpy.types.Scene) -> float:
    """Return the time [s] between two looks at the scene: a frame, or an even part of it."""
    return frame_s(scene) / looks_a_frame(scene)


def tick_s(scene: bpy.types.Scene) -> float:
    """Return the tick of a session of a scene [s]: at most a millisecond, and whole ticks between two looks.

    So on every frame a body is where its object is.
    """
    return look_s(scene) / math.ceil(look_s(scene) / TICK - 1e-9)


def looks(scene: bpy.types.Scene, frame: int) -> Iterator[float]:
    """Bring the scene from the frame before to this one; yield at each look the time [s] since the last."""
    count = looks_a_frame(scene)
    for look in range(1, count + 1):
        at = frame - 1 + look / count
        scene.frame_set(math.floor(at), subframe=at - math.floor(at))
        yield look_s(scene)


def is_playing(context: bpy.types.Context) -> bool:
    """Tell whether Blender plays the timeline."""
    return bool(context.screen and context.screen.is_animation_playing)
