"""What operators ask for before they can be used, and the sentences that say what is missing."""

import bpy

from ..core.errors import DimpleError
from . import fingertip_objects, modal_runs, sessions
from .translation import tip_

LARGEST = 1e9  # of a number an operator takes; NaN and infinity are none either


def refuse(operator: type, sentence: str) -> bool:
    """Say why an operator cannot be used now; Blender does not translate it, so it is looked up when it is shown."""
    operator.poll_message_set(tip_, sentence)
    return False


def check_numbers(operator: bpy.types.Operator, *names: str) -> None:
    """Raise a DimpleError when a number that was given to an operator is none that can be used."""
    for name in names:
        value = getattr(operator, name)
        if not all(abs(each) <= LARGEST for each in ([value] if isinstance(value, float) else value)):
            label = name.replace("_", " ").capitalize()
            raise DimpleError("{label} must be a number from -1e9 to 1e9.", label=label)


def needs_mesh(operator: type, context: bpy.types.Context) -> bool:
    """Tell whether the active object is a mesh."""
    if context.object is None or context.object.type != "MESH":
        return refuse(operator, "Select a mesh first")
    return True


def is_own(operator: type, body: bpy.types.Object) -> bool:
    """Tell whether an object and its material belong to this file, so that settings stay with it."""
    if body.override_library:
        return refuse(operator, "Settings of a library override would not be saved: make the object local first")
    if body.library or body.data.library:
        return refuse(operator, "The object is linked from another file: make it local first")
    if body.active_material and body.active_material.library:
        return refuse(operator, "The material is linked from another file: make it local first")
    return True


def is_free(operator: type) -> bool:
    """Tell whether nothing runs that may not be disturbed."""
    if modal_runs.at_work():
        return refuse(operator, "A bake or a virtual press is running; Esc cancels it")
    return True


def has_free_fingertips(operator: type, scene: bpy.types.Scene, count: int) -> bool:
    """Tell whether some fingertips are not in use."""
    if len(fingertip_objects.free(scene)) < count:
        return refuse(operator, "All three fingertips are in use; take one out of its slot first")
    return True


def can_press(operator: type, context: bpy.types.Context) -> bool:
    """Tell whether the active object can be pressed virtually."""
    body = context.object
    if context.mode != "OBJECT":
        return refuse(operator, "Go back to Object Mode first")
    if body is None or body.type != "MESH" or body in sessions.fingertip_objects(context.scene):
        return refuse(operator, "Select the mesh to press")
    return is_free(operator)
