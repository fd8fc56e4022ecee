"""Two materials beside each other: a twin of the object with a copy of its material, which the same press presses."""

import bpy
from mathutils import Matrix, Vector

from . import modal_runs, polls, sessions, twins
from .messages import report, say
from .names import Op


class DIMPLE_OT_compare_materials(polls.Declared, bpy.types.Operator):
    """Compare two materials: put a copy of the object, with a material of its own, beside it. One press presses both"""

    bl_idname = Op.COMPARE_MATERIALS
    bl_label = "Compare Materials"
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode, polls.needs_mesh, polls.is_own,
        polls.need(
            lambda context: context.object.dimple.enabled and context.object.active_material,
            "Make the object soft first",
        ),
        polls.need(
            lambda context: not twins.other(context.object, context.scene),
            "The object has a twin already: use one of the two materials first",
        ),
        polls.need(
            lambda _: not (sessions.sessions or modal_runs.runs),
            "Something is being pressed: end that first, with Esc or Reset",
        ),
    )  # fmt: skip

    def run(self, context: bpy.types.Context) -> None:
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
        say(self, {"INFO"}, polls.tip_("{} is its twin: select it and change its material").format(f'"{twin.name}"'))


class DIMPLE_OT_use_material(polls.Declared, bpy.types.Operator):
    """Decide between two compared materials: keep that of the selected object, and remove the copy"""

    bl_idname = Op.USE_MATERIAL
    bl_label = "Use This Material"
    bl_options = {"REGISTER", "UNDO"}

    needs = (
        polls.in_object_mode,
        polls.need(
            lambda context: context.object and twins.other(context.object, context.scene),
            "The object has no twin: Compare Materials makes one",
        ),
        polls.is_free,
    )

    def run(self, context: bpy.types.Context) -> None:
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
