"""A disk that fills ends a recording or a bake in a sentence, and costs nothing but what did not fit."""

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_bake import cached
from tests.blender.operators.test_sessions import is_clean
from tests.point_cache import cache_of

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
SAMPLE = 42 * 12  # bytes of a ball of 42 vertices


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """Let no file grow beyond a size [bytes], as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_disk_that_fills_while_recording_ends_the_recording_and_not_the_session(
    bpy: ModuleType, sessions: Any, scene: Any, playing: Any, coordinates: Bits, rest: bytes
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    obj = playing()
    bpy.ops.dimple.record()
    body, said = sessions.get(obj), []
    with full_after(32 + 3 * SAMPLE + 100):
        while body.recording and len(said) < 20:
            said += live_step.advance(bpy.context, 1 / 24)
    assert len(said) == 1 and said[0].startswith('The recording of "Ball" has ended early: ')
    assert live_step.advance(bpy.context, 1 / 24) == [] and body.frame.time > 0
    bpy.ops.dimple.reset()
    assert coordinates(obj) == rest and is_clean(obj)
    assert cache_of(obj).filepath == body.take[0]
    _, positions = cached(scene, obj)
    assert positions.shape == (3, 42, 3) and np.isfinite(positions).all()
    bpy.ops.dimple.play(seconds=0.02)
    bpy.ops.dimple.reset()
    assert coordinates(obj) == rest, "no dent was taken for the rest shape"


def test_a_recording_that_cannot_begin_leaves_no_file_and_records_nothing(
    bpy: ModuleType, sessions: Any, scene: Any, playing: Any, ball: Add
) -> None:
    playing()
    ball("Fine", 3)
    bpy.ops.dimple.play(seconds=0.02)
    with full_after(32 + SAMPLE + 1), pytest.raises(RuntimeError, match="Recording failed") as caught:
        bpy.ops.dimple.record()
    assert "Traceback" not in str(caught.value)
    assert not any(body.recording for body in sessions.sessions.values())
    assert list(Path(scene.dimple.cache_dir).iterdir()) == []
    bpy.ops.dimple.reset()


@pytest.mark.parametrize("target", ["MESH_CACHE", "SHAPE_KEYS"])
@pytest.mark.parametrize("size", [0, 16, 32 + 3 * SAMPLE + 100])
def test_a_disk_that_fills_while_baking_leaves_no_part_and_the_earlier_bake(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], coordinates: Bits, target: str, size: int
) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=4)
    before, at_rest = (
        {path.name: path.read_bytes() for path in Path(scene.dimple.cache_dir).iterdir()},
        coordinates(obj),
    )
    with full_after(size), pytest.raises(RuntimeError, match="The bake failed") as caught:
        bpy.ops.dimple.bake(frame_start=1, frame_end=30, target=target)
    assert "Traceback" not in str(caught.value)
    assert {path.name: path.read_bytes() for path in Path(scene.dimple.cache_dir).iterdir()} == before
    assert len(obj.modifiers) == 1 and coordinates(obj) == at_rest and obj.data.shape_keys is None
