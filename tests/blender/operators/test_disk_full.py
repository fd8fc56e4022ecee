"""A disk that fills ends a bake in a sentence, and costs nothing but what did not fit."""

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

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


@pytest.mark.parametrize("size", [0, 16, 32 + 3 * SAMPLE + 100])
def test_a_disk_that_fills_while_baking_leaves_no_part_and_the_earlier_bake(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], coordinates: Bits, size: int
) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=4)
    before, at_rest = (
        {path.name: path.read_bytes() for path in Path(scene.dimple.cache_dir).iterdir()},
        coordinates(obj),
    )
    with full_after(size), pytest.raises(RuntimeError, match="The bake failed") as caught:
        bpy.ops.dimple.bake(frame_start=1, frame_end=30)
    assert "Traceback" not in str(caught.value)
    assert {path.name: path.read_bytes() for path in Path(scene.dimple.cache_dir).iterdir()} == before
    assert len(obj.modifiers) == 1 and coordinates(obj) == at_rest
