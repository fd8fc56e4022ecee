"""Force, depth and pressure of a press as keyframed custom properties of the object, which drivers can read."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import bpy

# name of the custom property: unit, description, and the columns of the table of which the sum or the most is taken
CURVES = {
    "dimple_force_n": ("Force on all fingertips (N)", sum, "force_"),
    "dimple_depth_mm": ("Depth of the deepest fingertip (mm)", max, "depth_"),
    "dimple_pressure_pa": ("Pressure of what is inside (Pa)", sum, "pressure_"),
}


def add(obj: bpy.types.Object, table: Path) -> None:
    """Keyframe the properties of an object by the table of its bake or recording, a key a frame.

    Raises:
        OSError: the table cannot be read.
    """
    remove(obj)
    with table.open(newline="", encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    curves = _curves_of(obj, make=True)
    if curves is None or not rows:
        return
    for name, (description, taken, start) in CURVES.items():
        values = [taken(value for column, value in row.items() if column.startswith(start)) for row in rows]
        obj[name] = values[0]
        obj.id_properties_ui(name).update(description=description)
        curve = curves.new(f'["{name}"]')
        curve.keyframe_points.add(len(rows))
        keys = [each for row, value in zip(rows, values, strict=True) for each in (row["frame"], value)]
        curve.keyframe_points.foreach_set("co", keys)
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
        curve.update()


def remove(obj: bpy.types.Object) -> None:
    """Take the properties and their keyframes off an object; an action with nothing else in it goes too."""
    curves = _curves_of(obj, make=False)
    ours = list(_ours(curves)) if curves is not None else []
    for curve in ours:
        curves.remove(curve)
    for name in CURVES:
        if name in obj:
            del obj[name]
    animation = obj.animation_data
    if ours and not len(curves) and not (animation.drivers or animation.nla_tracks):
        action = animation.action
        obj.animation_data_clear()
        if not action.users:
            bpy.data.actions.remove(action)


def _ours(curves: bpy.types.ActionChannelbagFCurves) -> Iterator[bpy.types.FCurve]:
    paths = {f'["{name}"]' for name in CURVES}
    return (curve for curve in curves if curve.data_path in paths)


def _curves_of(obj: bpy.types.Object, *, make: bool) -> bpy.types.ActionChannelbagFCurves | None:
    """Return the curves of an object's action, None where there is none or it is linked from another file."""
    animation = obj.animation_data
    if make:
        animation = animation or obj.animation_data_create()
        if animation.action is None:
            animation.action = bpy.data.actions.new(f"{obj.name} Press")
    action = animation.action if animation else None
    if action is None or action.library:
        return None
    if make:
        animation.action_slot = animation.action_slot or action.slots.new("OBJECT", obj.name)
        layer = action.layers[0] if action.layers else action.layers.new("Layer")
        strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
        return strip.channelbag(animation.action_slot, ensure=True).fcurves
    slot = animation.action_slot
    strips = [strip for layer in action.layers for strip in layer.strips]
    bag = strips[0].channelbag(slot) if strips and slot else None
    return bag.fcurves if bag else None
