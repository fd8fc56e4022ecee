"""Animation curves of Blender: found, drawn with straight lines, and removed with an action that holds nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import bpy


def curve_bags(owner: bpy.types.ID) -> Iterator[bpy.types.ActionChannelbag]:
    """Yield what holds the curves of an object or of a mesh's keys, where there are any; linked ones are left out."""
    animation = owner.animation_data
    action = animation.action if animation else None
    for layer in action.layers if action and not action.library else ():
        for strip in layer.strips:
            bag = strip.channelbag(animation.action_slot) if animation.action_slot else None
            if bag and len(bag.fcurves):
                yield bag


def bag_in(action: bpy.types.Action, slot: bpy.types.ActionSlot) -> bpy.types.ActionChannelbag:
    """Return what holds the curves of a slot in an action; it is made where it is missing."""
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True)


def draw(bag: bpy.types.ActionChannelbag, path: str, frames: Sequence[float], values: Sequence[float]) -> None:
    """Add the curve of a data path, with straight lines from key to key."""
    curve = bag.fcurves.new(path)
    curve.keyframe_points.add(len(frames))
    curve.keyframe_points.foreach_set("co", [each for pair in zip(frames, values, strict=True) for each in pair])
    straighten(curve)
    curve.update()


def straighten(curve: bpy.types.FCurve) -> None:
    """Let straight lines lead from key to key."""
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"


def remove(owner: bpy.types.ID, is_ours: Callable[[str], bool]) -> None:
    """Take the curves of some data paths off an owner; an action with nothing else in it goes too."""
    ours = [(bag, curve) for bag in curve_bags(owner) for curve in bag.fcurves if is_ours(curve.data_path)]
    for bag, curve in ours:
        bag.fcurves.remove(curve)
    animation = owner.animation_data
    if ours and not any(curve_bags(owner)) and not (animation.drivers or animation.nla_tracks):
        action = animation.action
        owner.animation_data_clear()
        if not action.users:
            bpy.data.actions.remove(action)
