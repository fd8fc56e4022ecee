"""What an object meets: the settings of contact, and their panel."""

import bpy
from bpy.props import BoolProperty, FloatProperty

from .reduction_settings import FIXED


class ContactSettings:
    """The properties of an object that say what it meets."""

    collider: BoolProperty(
        name="Dimple Collider",
        description="Running bodies meet this object, and each other; nothing passes through them",
        default=False, **FIXED,
    )  # fmt: skip
    collider_friction: FloatProperty(
        name="Collider Friction",
        description="Coefficient of friction of this object with bodies that touch it; 0 is frictionless",
        default=0.5, min=0.0, soft_max=1.5, precision=2, **FIXED,
    )  # fmt: skip
    is_prop: BoolProperty(
        name="Falls",
        description="The collider is a prop: it falls by its weight and rests on soft bodies, other colliders, other "
        "props and the ground",
        default=False, **FIXED,
    )  # fmt: skip
    prop_mass_kg: FloatProperty(
        name="Prop Mass (kg)", description="Mass of what falls", default=1.0, min=0.0, soft_min=0.001, soft_max=100.0,
        step=10, precision=3, **FIXED,
    )  # fmt: skip
    self_contact: BoolProperty(
        name="Self Contact", description="The body does not pass through itself where it folds", default=False, **FIXED
    )


class DIMPLE_PT_contact(bpy.types.Panel):
    """What the object meets."""

    bl_label = "Contact"
    bl_parent_id = "DIMPLE_PT_body"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Show on every object, as the panel it is in."""
        return context.object is not None

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the switches of contact."""
        settings, layout = context.object.dimple, self.layout
        layout.use_property_split = True
        layout.enabled = context.object.type == "MESH"
        layout.prop(settings, "collider")
        row = layout.row()
        row.active = settings.collider and not settings.enabled
        row.prop(settings, "collider_friction", slider=True)
        column = layout.column()
        column.active = settings.collider and not settings.enabled
        column.prop(settings, "is_prop")
        row = column.row()
        row.active = settings.is_prop
        row.prop(settings, "prop_mass_kg")
        row = layout.row()
        row.active = settings.enabled
        row.prop(settings, "self_contact")
