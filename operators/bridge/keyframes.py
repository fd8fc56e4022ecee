"""Find, draw and remove animation curves of Blender.

Force, depth and pressure of a press become curves of custom properties of the object, which drivers can read.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import bpy

# name of the custom property: description, function that combines columns of the table, and prefix of these columns
CURVES = {
    "dimple_force_n": ("Force on all fingertips (N)", sum, "force_"),
    "dimple_depth_mm": ("Depth of the deepest fingertip (mm)", max, "depth_"),
    "dimple_pressure_pa": ("Pressure of what is inside (Pa)", sum, "pressure_"),
}


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


def remove(owner: bpy.types.ID, is_ours: Callable[[str], bool]) -> None:
    """Remove the curves of some data paths from an owner, and its action if nothing else is in it."""
    ours = [(bag, curve) for bag in curve_bags(owner) for curve in bag.fcurves if is_ours(curve.data_path)]
    for bag, curve in ours:
        bag.fcurves.remove(curve)
    animation = owner.animation_data
    if ours and not any(curve_bags(owner)) and not (animation.drivers or animation.nla_tracks):
        action = animation.action
        owner.animation_data_clear()
        if not action.users:
            bpy.data.actions.remove(action)


def add_press(obj: bpy.types.Object, table: Path) -> None:
    """Keyframe the custom properties of an object from the table of its bake or recording, one key per frame.

    Raises:
        OSError: the table cannot be read.
    """
    remove_press(obj)
    with table.open(newline="", encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    animation = obj.animation_data or obj.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f"{obj.name} Press")
    action = animation.action
    if action.library or not rows:
        return
    animation.action_slot = animation.action_slot or action.slots.new("OBJECT", obj.name)
    bag = bag_in(action, animation.action_slot)
    for name, (description, taken, start) in CURVES.items():
        values = [taken(value for column, value in row.items() if column.startswith(start)) for row in rows]
        obj[name] = values[0]
        obj.id_properties_ui(name).update(description=description)
        draw(bag, f'["{name}"]', [row["frame"] for row in rows], values)


def remove_press(obj: bpy.types.Object) -> None:
    """Remove the custom properties of a press and their keyframes from an object."""
    remove(obj, lambda path: path in {f'["{name}"]' for name in CURVES})
    for name in CURVES:
        if name in obj:
            del obj[name]
