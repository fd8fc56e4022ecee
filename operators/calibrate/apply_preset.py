"""Apply the constants of a measured object to the active material."""

from typing import TYPE_CHECKING

import bpy
from bpy.props import StringProperty

from ...core.errors import DimpleError
from ..bridge import sizing
from ..names import Op
from ..press import polls

if TYPE_CHECKING:
    from ...core.material import Preset


def material_of(obj: bpy.types.Object, name: str) -> bpy.types.Material:
    """Return the active material of a mesh; a new one if it has none."""
    if obj.active_material is None:
        obj.active_material = bpy.data.materials.new(name)
    return obj.active_material


class DIMPLE_OT_apply_preset(polls.Declared, bpy.types.Operator):
    """Give the active object the material and the size of a measured or everyday object"""

    bl_idname = Op.APPLY_PRESET
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(name="Preset", description="Name of a measured object, such as object_2_vinyl_air")

    needs = polls.needs_mesh, polls.is_own

    def run(self, context: bpy.types.Context) -> None:
        from ...core.everyday_presets import OBJECTS

        preset = next((each for each in OBJECTS if each.name == self.preset), None)
        if preset is None:
            known = ", ".join(each.name for each in OBJECTS)
            raise DimpleError('There is no preset "{preset}". There are: {known}.', preset=self.preset, known=known)
        give(context.object, preset)


def give(obj: bpy.types.Object, preset: "Preset") -> None:
    """Make a mesh a soft body with a preset's material, size and sway, and fit fingertip and depth to it."""
    apply(material_of(obj, preset.label).dimple, preset)
    obj.dimple.enabled, obj.dimple.size_mode, obj.dimple.size_mm = True, "CUSTOM", preset.size * 1e3
    obj.dimple.sway, obj.dimple.sway_hz = preset.sway, preset.sway_hz
    sizing.fit(bpy.context.scene, obj)


def apply(settings: bpy.types.PropertyGroup, preset: "Preset") -> None:
    """Give a material's settings the constants of a preset."""
    constants = preset.material
    settings.K1, settings.K2, settings.k = constants.K1 / 1e3, constants.K2 / 1e3, constants.k / 1e3
    settings.x0, settings.spread_mm = constants.x0 * 1e3, (constants.spread or 0.0) * 1e3
    if constants.mass is not None:
        settings.mass_from, settings.mass_kg = "MASS", constants.mass
    else:
        settings.mass_from, settings.density = "DENSITY", constants.density
    settings.damping_ratio, settings.friction = constants.damping_ratio, constants.friction
    settings.fill, settings.pressure_kpa = constants.fill.upper(), constants.pressure / 1e3
    tip = constants.indenter
    settings.tip, settings.tip_radius_mm, settings.calibration = tip.shape.upper(), tip.radius * 1e3, ""
    settings.provenance = preset.provenance  # last, because setting a constant marks the material as edited
