"""How large a body is that nobody has given a size: what is modelled as large as a house stands for a small thing."""

import bpy

from .messages import Note

LARGEST = 100  # fingertip radii: a larger body shows no dent, and is none that was measured
SMALLEST_M = 0.01


def settle_size(scene: bpy.types.Scene, obj: bpy.types.Object) -> Note | None:
    """Give a body that has no size yet one that a fingertip suits; return a note where that is not the modelled one."""
    if not is_unsuited(scene, obj):
        return None
    settings = obj.dimple
    settings.size_mode = "CUSTOM"
    return Note(
        f'"{obj.name}": {_as_modelled(scene, obj):.3g} m across as modelled does not suit a fingertip of '
        f"{scene.dimple.finger_radius_mm:.3g} mm: it is pressed as an object of {settings.size_mm:.3g} mm. "
        "Physical Size in Physics > Dimple changes that."
    )


def is_unsuited(scene: bpy.types.Scene, obj: bpy.types.Object) -> bool:
    """Tell whether a body that nobody has given a size is too large or too small for a fingertip as it is modelled."""
    if obj.dimple.enabled or obj.dimple.is_property_set("size_mode"):
        return False
    return not SMALLEST_M <= _as_modelled(scene, obj) <= LARGEST * scene.dimple.finger_radius_mm / 1e3


def _as_modelled(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    return float(max(obj.dimensions)) * scene.unit_settings.scale_length


def scales_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> tuple[float, float, float]:
    """Return metres of the real object per unit of its mesh, along each axis of the mesh."""
    settings, largest = obj.dimple, max(obj.dimensions)
    per_unit = scene.unit_settings.scale_length
    if (settings.size_mode == "CUSTOM" or is_unsuited(scene, obj)) and largest > 0:
        per_unit = settings.size_mm / 1e3 / largest
    x, y, z = (per_unit * abs(each) for each in obj.matrix_world.to_scale())
    return x, y, z
