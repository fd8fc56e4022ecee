"""How large a body is that nobody has given a size, and the fingertip that fits it."""

import math

import bpy

from ...core.messages import Message, about
from ..messages import Note

SMALLEST_M, LARGEST_M = 0.01, 1.0  # across: what is modelled outside of that stands for a thing that was measured
SHARES = {"finger_radius_mm": 10 / 165, "press_depth_mm": 15 / 165}  # of a body's size, until they are typed
LEAST_MM = 0.01  # of either
NUMBERS = (1, 2, 3)  # of the fingertips


def fingertips(scene: bpy.types.Scene) -> list[bpy.types.Object | None]:
    """Return the fingertip object in each slot of a scene, None where one is empty."""
    return [getattr(scene.dimple, f"finger_{number}") for number in NUMBERS]


def settle_size(scene: bpy.types.Scene, obj: bpy.types.Object) -> Message | None:
    """Give a body that has no size yet one that was measured; return a note where that is not the modelled one."""
    if not is_unsuited(scene, obj):
        return None
    settings = obj.dimple
    settings.size_mode = "CUSTOM"
    said = Note(
        "{as_modelled:.3g} m across as modelled, but constants are measured on what one can hold: it is pressed as an "
        "object of {size_mm:.3g} mm. Physical Size in Physics > Dimple changes that.",
        as_modelled=_as_modelled(scene, obj), size_mm=settings.size_mm
    )  # fmt: skip
    return about(obj.name, said)


def is_unsuited(scene: bpy.types.Scene, obj: bpy.types.Object) -> bool:
    """Tell whether a body that nobody has given a size is too large or too small to be pressed as it is modelled."""
    if obj.dimple.enabled or obj.dimple.is_property_set("size_mode"):
        return False
    return not SMALLEST_M <= _as_modelled(scene, obj) <= LARGEST_M


def _as_modelled(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    return float(max(obj.dimensions)) * scene.unit_settings.scale_length


def metres_per_unit(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """Return metres of the real object per unit of the scene."""
    settings, largest = obj.dimple, max(obj.dimensions)
    if (settings.size_mode == "CUSTOM" or is_unsuited(scene, obj)) and largest > 0:
        return float(settings.size_mm / 1e3 / largest)
    return float(scene.unit_settings.scale_length)


def fit(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    """Fit fingertip and depth to the size of a body: what was typed stays, and all where an object that is drawn as no
    sphere presses as the scene's fingertip.
    """
    settings, size = scene.dimple, 1e3 * metres_per_unit(scene, obj) * max(obj.dimensions)
    if size <= 0 or not all(map(is_sphere, filter(None, fingertips(scene)))):
        return
    following = [name for name in SHARES if follows(settings, name)]
    settings.fitted_mm = size
    for name in following:
        setattr(settings, name, fitted(settings, name))


def fitted(settings: bpy.types.PropertyGroup, name: str) -> float:
    """Return what a setting of the fingertip [mm] is for the body that it was fitted to last."""
    return max(SHARES[name] * settings.fitted_mm, LEAST_MM)


def follows(settings: bpy.types.PropertyGroup, name: str) -> bool:
    """Tell whether a setting of the fingertip follows the size of the body: nobody has typed another."""
    return math.isclose(getattr(settings, name), fitted(settings, name), rel_tol=1e-6)


def is_sphere(obj: bpy.types.Object) -> bool:
    """Tell whether a sphere is drawn for an object."""
    return obj.type == "EMPTY" and obj.empty_display_type == "SPHERE"


def radius_of(obj: bpy.types.Object, scene: bpy.types.Scene, scale: float) -> float:
    """Return the radius of a fingertip [m]: that of its drawn sphere, else that of the scene.

    Args:
        scale: physical metres per scene unit.
    """
    if is_sphere(obj):
        return scale * obj.empty_display_size * obj.matrix_world.median_scale
    return scene.dimple.finger_radius_mm / 1e3
