"""Give a mesh a material with the constants of a preset."""

from typing import TYPE_CHECKING

import bpy

from . import sizing

if TYPE_CHECKING:
    from ...core.material import Preset


def material_of(obj: bpy.types.Object, name: str) -> bpy.types.Material:
    """Return the active material of a mesh; a new one if it has none."""
    if obj.active_material is None:
        obj.active_material = bpy.data.materials.new(name)
    return obj.active_material


def give(obj: bpy.types.Object, preset: "Preset") -> None:
    """Make a mesh a soft body with a preset's material, size and sway, and fit fingertip and depth to it."""
    _apply(material_of(obj, preset.label).dimple, preset)
    obj.dimple.enabled, obj.dimple.size_mode, obj.dimple.size_mm = True, "CUSTOM", preset.size * 1e3
    obj.dimple.sway, obj.dimple.sway_hz = preset.sway, preset.sway_hz
    sizing.fit(bpy.context.scene, obj)


def _apply(settings: bpy.types.PropertyGroup, preset: "Preset") -> None:
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
