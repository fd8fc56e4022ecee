"""What a running body was read from, as it is in the panels: to see when something has changed.

Whatever `to_params` returns belongs to it, so a new constant joins by itself.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, NamedTuple

import bpy

from . import body_model


class Settings(NamedTuple):
    """What a running body was read from.

    body: laws, pins, softness and size.
    materials: the constants of each slot.
    surroundings: gravity, ground and the unit of length.
    plan: how it is to be simulated.
    """

    body: Hashable
    materials: tuple[Hashable, ...]
    surroundings: Hashable
    plan: Hashable


def settings_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> Settings:
    """Return the settings of an object as they are now."""
    around = scene.dimple
    return Settings(
        tuple(obj.dimple.to_params().items()),
        tuple(_material(slot.material) for slot in obj.material_slots),
        (
            bool(around.use_gravity), body_model.gravity(scene), bool(around.use_ground),
            scene.unit_settings.scale_length,
        ),
        tuple(obj.dimple.to_plan().items()),
    )


def _material(material: bpy.types.Material | None) -> Hashable:
    if material is None:
        return None
    settings: Any = material.dimple
    return material.session_uid, tuple(settings.to_params().items())
