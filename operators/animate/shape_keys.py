"""A bake as shape keys: one key every few frames, faded in and out so that the frames in between are interpolated."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..bridge import keyframes, write_back
from ..bridge.scene_objects import Singles
from ..names import BAKED_KEY

MADE_BASIS = "dimple_made_basis"  # custom property of shape keys: the bake made their basis and will remove it


def add(obj: bpy.types.Object, shapes: Sequence[tuple[int, Singles]]) -> None:
    """Give an object a shape key for each frame, with its offsets (N, 3) from the shape at rest, and keyframe them.

    Between two keys their values add up to 1, so the shape is interpolated linearly.
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
    """Remove the shape keys of a bake and their keyframes from an object; return the number of keys."""
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
