"""Read the materials, pins and maps of an object into a model, and the settings that a model was read from.

These settings include everything that `to_params` returns, so a new constant needs no change here.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

from ...core.errors import DimpleError
from ...core.material import DEFAULT_MATERIAL, Material
from ...core.message import about
from ..names import MAPS
from ..reporting import Note
from . import advice, final_mesh, in_trial

if TYPE_CHECKING:
    from ...core.background_work import Parts
    from ...core.body.model import Model
    from ...core.mesh.surface import Mesh
    from .object_link import Floats, ObjectLink


def reading_model(scene: bpy.types.Scene, body: bpy.types.Object, mesh: Mesh, link: ObjectLink) -> Parts:
    """Read the materials and settings of an object into a model on the mesh that it was linked with, in parts.

    Blender's data is only read before the first part.

    Raises:
        DimpleError: the object cannot be pressed with its settings; the message says why, and what to do.
    """
    from ...core.body.model import build_model
    from ...core.mesh.surface import base_vertices

    params, surroundings = body.dimple.to_params(), scene.dimple
    name, said = body.name, advice.on_body(body, mesh, scene, link)
    try:
        pinned = base_vertices(mesh) if params["pinned"] == "" else None
        if group := params["pinned"]:
            pinned, least = _weights(body, group, "pin", link), 0.01 if params["sway"] else 0.5
            if not (pinned >= least).any():
                raise DimpleError(
                    'no vertex of the pin group "{group}" has a weight of {least:g} or more. Paint some.',
                    group=group, least=least,
                )  # fmt: skip
        materials = [in_trial.get(body.session_uid) or _material(body, slot) for slot in link.slots]
        groups = {name: params[f"{name}_group"] for name, _, _ in MAPS}
        maps = {name: _weights(body, group, name, link) for name, group in groups.items() if group}
        make = partial(
            build_model, mesh, materials, pinned=pinned, **maps,
            gravity=gravity(scene) if surroundings.use_gravity else (0.0, 0.0, 0.0),
            ground=0.0 if surroundings.use_ground else None, rigged=link.rigged,
            sway=(*params["sway"], gravity(scene)) if params["sway"] else None, bones=link.bones,
        )  # fmt: skip
        model: Model = yield 0.4, make
    except DimpleError as error:
        raise DimpleError(about(name, str(error))) from error
    repaired = map(Note, mesh.notes)  # these need no action
    said = (*said, *advice.on_fill(model), *advice.on_sway(model, params["sway"]))
    return replace(model, notes=(*repaired, *model.notes[len(mesh.notes) :], *said))


def gravity(scene: bpy.types.Scene) -> tuple[float, ...]:
    """Return the gravity of a scene (3,) [m/s2]; zero if the scene has it switched off."""
    return tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)


def _material(body: bpy.types.Object, slot: int) -> Material:
    """Return the constants of a body's material.

    Raises:
        DimpleError: a constant is out of its range.
    """
    material = body.material_slots[slot].material if body.material_slots else None
    if material is None:
        return DEFAULT_MATERIAL
    try:
        return Material(**material.dimple.to_params())
    except DimpleError as error:
        raise DimpleError('material "{name}": {error}', name=material.name, error=error) from error


def _weights(body: bpy.types.Object, group: str, role: str, link: ObjectLink) -> Floats:
    """Return the weight (N,) of every vertex in a vertex group, 0 outside it, or the float attribute of that name."""
    found = final_mesh.weights(bpy.context, body, group, link.cuts)
    if found is None:
        raise DimpleError(
            'there is no vertex group "{group}" ({role}). Choose another in Physics > Dimple.', group=group, role=role
        )
    return found


class Settings(NamedTuple):
    """The settings that a running body was read from."""

    body: Hashable  # pins, painted maps, sway and size
    materials: tuple[Hashable, ...]  # the constants of each slot
    surroundings: Hashable  # gravity, ground and the unit of length
    plan: Hashable  # mesh or proxy, and self contact


def settings_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> Settings:
    """Return the settings of an object as they are now."""
    around = scene.dimple
    return Settings(
        tuple(obj.dimple.to_params().items()),
        tuple(_constants(slot.material) for slot in obj.material_slots),
        (
            bool(around.use_gravity), gravity(scene), bool(around.use_ground),
            scene.unit_settings.scale_length,
        ),
        tuple(obj.dimple.to_plan().items()),
    )


def _constants(material: bpy.types.Material | None) -> Hashable:
    if material is None:
        return None
    settings: Any = material.dimple
    return material.session_uid, tuple(settings.to_params().items())
