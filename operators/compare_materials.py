"""Two materials beside each other: a twin of the object with a copy of its material, which the same press presses."""

import bpy
from mathutils import Matrix, Vector

from ..core.messages import Message
from . import modal_runs, polls, sessions, twins
from .messages import report, say
from .names import Op


class DIMPLE_OT_compare_materials(bpy.types.Operator):
    """Put a twin with a copy of the material beside the object; one press presses both, so that two can be compared"""

    bl_idname = Op.COMPARE_MATERIALS
    bl_label = "Compare Materials"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a soft body without a twin, and nothing that runs."""
        obj = context.object
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode first")
        if not polls.needs_mesh(cls, context) or not polls.is_own(cls, obj):
            return False
        if not obj.dimple.enabled or obj.active_material is None:
            return polls.refuse(cls, "Make the object soft first")
        if twins.other(obj, context.scene):
            return polls.refuse(cls, "The object has a twin already: use one of the two materials first")
        if sessions.sessions or modal_runs.runs:
            return polls.refuse(cls, "Something is being pressed: end that first, with Esc or Reset")
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Copy object, mesh and materials."""
        obj = context.object
        twin = obj.copy()
        twin.data, twin.name = obj.data.copy(), f"{obj.name} B"
        twin.animation_data_clear()
        twin.constraints.clear()
        twin.parent = None
        copies = {slot.material: slot.material.copy() for slot in obj.material_slots if slot.material}
        for slot in twin.material_slots:
            if slot.material:
                copy = copies[slot.material]
                copy.name, slot.material = f"{slot.material.name} B", copy
        for collection in obj.users_collection:
            collection.objects.link(twin)
        twin.matrix_world = Matrix.Translation(beside(context, obj)) @ obj.matrix_world
        twin.dimple.twin = obj
        twin.select_set(False)
        say(self, {"INFO"}, Message(
            '"{name}" is its twin: select it and change its material', name=twin.name
        ))  # fmt: skip
        return {"FINISHED"}


class DIMPLE_OT_use_material(bpy.types.Operator):
    """Keep the material of the selected one of two twins, and remove the copy"""

    bl_idname = Op.USE_MATERIAL
    bl_label = "Use This Material"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Need a twin."""
        if context.mode != "OBJECT":
            return polls.refuse(cls, "Go back to Object Mode first")
        if context.object is None or not twins.other(context.object, context.scene):
            return polls.refuse(cls, "The object has no twin: Compare Materials makes one")
        return polls.is_free(cls)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Give the original the materials that were chosen, and remove its copy."""
        chosen, other = context.object, twins.other(context.object, context.scene)
        original, copy = (other, chosen) if chosen.dimple.twin == other else (chosen, other)
        report(self, sessions.stop_all())
        left = {slot.material for slot in other.material_slots} - {slot.material for slot in chosen.material_slots}
        if chosen == copy:
            for theirs, ours in zip(copy.material_slots, original.material_slots, strict=False):
                ours.material = theirs.material
        mesh = copy.data
        bpy.data.objects.remove(copy)
        for data, users in ((bpy.data.meshes, [mesh]), (bpy.data.materials, left - {None})):
            for each in users:
                if not each.users:
                    data.remove(each)
        context.view_layer.objects.active = original
        original.select_set(True)
        return {"FINISHED"}


def beside(context: bpy.types.Context, obj: bpy.types.Object) -> Vector:
    """Return the way from an object to its twin in the scene: to the right as it is seen, level."""
    view = context.region_data if context.area and context.area.type == "VIEW_3D" else None
    right = Vector((1.0, 0.0, 0.0))
    if view:
        right = view.view_rotation @ right
        right.z = 0.0
        right = right.normalized() if right.length > 1e-3 else Vector((1.0, 0.0, 0.0))
    corners = [(obj.matrix_world @ Vector(corner)) @ right for corner in obj.bound_box]
    return right * max(twins.APART * (max(corners) - min(corners)), 1e-6)


register, unregister = bpy.utils.register_classes_factory([DIMPLE_OT_compare_materials, DIMPLE_OT_use_material])
