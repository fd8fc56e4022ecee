"""What operators ask for before they can be used, and the sentences that say what is missing."""

import bpy

from . import sessions


def needs_mesh(operator: type, context: bpy.types.Context) -> bool:
    """Tell whether the active object is a mesh."""
    if context.object is None or context.object.type != "MESH":
        operator.poll_message_set("Select a mesh first")
        return False
    return True


def is_free(operator: type) -> bool:
    """Tell whether nothing runs that may not be disturbed."""
    if sessions.at_work():
        operator.poll_message_set("A bake, a comparison or a virtual press is running; Esc cancels it")
        return False
    return True


def can_press(operator: type, context: bpy.types.Context) -> bool:
    """Tell whether the active object can be pressed virtually."""
    body = context.object
    if context.mode != "OBJECT":
        operator.poll_message_set("Go back to Object Mode first")
    elif body is None or body.type != "MESH" or body in sessions.fingertip_objects(context.scene):
        operator.poll_message_set("Select the mesh to press")
    else:
        return is_free(operator)
    return False


def can_measure(operator: type, context: bpy.types.Context) -> bool:
    """Tell whether the active object can be pressed by a measuring tip: it needs a material of this file."""
    if not can_press(operator, context):
        return False
    material = context.object.active_material
    if material is None:
        operator.poll_message_set("Give the object a material first: calibrate, or choose a preset")
    elif material.library:
        operator.poll_message_set("The material is linked from another file: make it local first")
    else:
        return True
    return False
