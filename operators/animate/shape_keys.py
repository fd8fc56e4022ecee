"""A bake as shape keys: one key every few frames, faded in and out so that the frames between are interpolated."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..bridge import keyframes, write_back
from ..bridge.scene_objects import Singles
from ..names import BAKED_KEY

MADE_BASIS = "dimple_made_basis"  # custom property of keys that came with the bake and go with it


def add(obj: bpy.types.Object, shapes: Sequence[tuple[int, Singles]]) -> None:
    """Give an object a key for each frame and its offsets (N, 3) from the shape at rest, and keyframe them.

    Between two keys the values add up to 1, and a straight line leads from one shape to the next.
    """
    remove(obj)
    if write_back.is_shared(obj.data):
        obj.data = obj.data.copy()
    made_basis = obj.data.shape_keys is None
    frames = [frame for frame, _ in shapes]
    for at, (frame, offsets) in enumerate(shapes):
        key = write_back.add_key(obj, f"{BAKED_KEY}{frame:04d}", offsets)
        for other in frames[max(at - 1, 0) : at + 2]:
            key.value = float(other == frame)
            key.keyframe_insert("value", frame=other)
    if made_basis:
        obj.data.shape_keys[MADE_BASIS] = True
    for bag in keyframes.curve_bags(obj.data.shape_keys):
        for curve in filter(lambda each: _is_ours(each.data_path), bag.fcurves):
            keyframes.straighten(curve)


def remove(obj: bpy.types.Object) -> int:
    """Take the keys of a bake off an object with their keyframes; return how many there were."""
    keys = obj.data.shape_keys
    baked = [key.name for key in keys.key_blocks if key.name.startswith(BAKED_KEY)] if keys else []
    if not baked:
        return 0
    keyframes.remove(keys, _is_ours)
    active = obj.active_shape_key_index
    for name in baked:
        obj.shape_key_remove(obj.data.shape_keys.key_blocks[name])
    keys = obj.data.shape_keys
    if keys and keys.get(MADE_BASIS):
        if len(keys.key_blocks) == 1:
            obj.shape_key_remove(keys.key_blocks[0])
        else:
            del keys[MADE_BASIS]
    if obj.data.shape_keys:
        obj.active_shape_key_index = min(active, len(obj.data.shape_keys.key_blocks) - 1)
    return len(baked)


def _is_ours(path: str) -> bool:
    return path.startswith(f'key_blocks["{BAKED_KEY}')
