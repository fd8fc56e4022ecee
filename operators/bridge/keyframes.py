"""Find and draw animation curves of Blender."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import bpy


def curve_bags(owner: bpy.types.ID) -> Iterator[bpy.types.ActionChannelbag]:
    """Yield the channel bags with curves of an object or of a mesh's shape keys; linked actions are left out."""
    animation = owner.animation_data
    action = animation.action if animation else None
    for layer in action.layers if action and not action.library else ():
        for strip in layer.strips:
            bag = strip.channelbag(animation.action_slot) if animation.action_slot else None
            if bag and len(bag.fcurves):
                yield bag


def bag_in(action: bpy.types.Action, slot: bpy.types.ActionSlot) -> bpy.types.ActionChannelbag:
    """Return the channel bag for the curves of a slot in an action; it is made if missing."""
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True)


def draw(
    bag: bpy.types.ActionChannelbag, path: str, frames: Sequence[float], values: Sequence[float], axis: int = 0
) -> None:
    """Add a curve of a data path, with linear interpolation."""
    curve = bag.fcurves.new(path, index=axis)
    curve.keyframe_points.add(len(frames))
    curve.keyframe_points.foreach_set("co", [each for pair in zip(frames, values, strict=True) for each in pair])
    straighten(curve)
    curve.update()


def straighten(curve: bpy.types.FCurve) -> None:
    """Make the interpolation of a curve linear."""
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
