"""Force, depth and pressure of a press as keyframed custom properties of the object, which drivers can read."""

from __future__ import annotations

import csv
from pathlib import Path

import bpy

from . import keyframes

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
    animation = obj.animation_data or obj.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f"{obj.name} Press")
    action = animation.action
    if action.library or not rows:
        return
    animation.action_slot = animation.action_slot or action.slots.new("OBJECT", obj.name)
    bag = keyframes.bag_in(action, animation.action_slot)
    for name, (description, taken, start) in CURVES.items():
        values = [taken(value for column, value in row.items() if column.startswith(start)) for row in rows]
        obj[name] = values[0]
        obj.id_properties_ui(name).update(description=description)
        keyframes.draw(bag, f'["{name}"]', [row["frame"] for row in rows], values)


def remove(obj: bpy.types.Object) -> None:
    """Take the properties and their keyframes off an object."""
    keyframes.remove(obj, lambda path: path in {f'["{name}"]' for name in CURVES})
    for name in CURVES:
        if name in obj:
            del obj[name]
