"""The size of a body for which nobody has set one, and the fingertip that fits it."""

import math

import bpy

from ...core.message import Message, about
from ..reporting import Note

SMALLEST_M, LARGEST_M = 0.01, 1.0  # [m] a body modelled smaller or larger is pressed at a custom size
USUAL_MM = 165.0  # [mm] size of the paper's vinyl cube, for which the defaults below are
DEFAULTS = {"finger_radius_mm": 10.0, "press_depth_mm": 15.0}  # [mm] they grow with a body's size, unless typed
LEAST_MM = 0.01  # [mm] smallest radius or depth
NUMBERS = (1, 2, 3)  # of the fingertips


def fingertips(scene: bpy.types.Scene) -> list[bpy.types.Object | None]:
    """Return the fingertip object in each slot of a scene, None for an empty slot."""
    return [getattr(scene.dimple, f"finger_{number}") for number in NUMBERS]


def settle_size(scene: bpy.types.Scene, obj: bpy.types.Object) -> Message | None:
    """Set a custom size if nobody has set the size of a body and the modelled one is unsuited; return a note if so."""
    if not is_unsuited(scene, obj):
        return None
    settings = obj.dimple
    settings.size_mode = "CUSTOM"
    said = Note(
        "{as_modelled:.3g} m across as modeled, but constants are measured on objects that fit in a hand, so it is "
        "pressed as an object of {size_mm:.3g} mm. Change that with Physical Size in Physics > Dimple.",
        as_modelled=_as_modelled(scene, obj), size_mm=settings.size_mm
    )  # fmt: skip
    return about(obj.name, said)


def is_unsuited(scene: bpy.types.Scene, obj: bpy.types.Object) -> bool:
    """Return whether a body without a set size is too large or too small to be pressed as modelled."""
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


def size_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """Return the largest dimension of the real object [mm]."""
    return 1e3 * metres_per_unit(scene, obj) * max(obj.dimensions)


def fit(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    """Fit radius and depth of the fingertip to the size of a body, except typed values; change nothing if a fingertip
    object is not drawn as a sphere, because it presses with the radius of the scene.
    """
    settings, size = scene.dimple, size_of(scene, obj)
    if size <= 0 or not all(map(is_sphere, filter(None, fingertips(scene)))):
        return
    following = [name for name in DEFAULTS if follows(settings, name)]
    settings.fitted_mm = size
    for name in following:
        setattr(settings, name, fitted(settings, name))


def fitted(settings: bpy.types.PropertyGroup, name: str) -> float:
    """Return the value of a fingertip setting [mm] that fits the body of the last fit."""
    return max(DEFAULTS[name] * settings.fitted_mm / USUAL_MM, LEAST_MM)


def follows(settings: bpy.types.PropertyGroup, name: str) -> bool:
    """Return whether a fingertip setting follows the size of the body, that is, nobody has typed another value."""
    return math.isclose(getattr(settings, name), fitted(settings, name), rel_tol=1e-6)


def is_sphere(obj: bpy.types.Object) -> bool:
    """Return whether an object is drawn as a sphere."""
    return obj.type == "EMPTY" and obj.empty_display_type == "SPHERE"


def radius_of(obj: bpy.types.Object, scene: bpy.types.Scene, scale: float) -> float:
    """Return the radius of a fingertip [m]: that of its drawn sphere, else that of the scene.

    Args:
        scale: physical metres per scene unit.
    """
    if is_sphere(obj):
        return scale * obj.empty_display_size * obj.matrix_world.median_scale
    return scene.dimple.finger_radius_mm / 1e3
