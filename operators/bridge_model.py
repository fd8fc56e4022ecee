"""Materials, pins and maps of an object, read into a model. Part of the bridge."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ..core.base import DimpleError
from ..core.steps import Parts, at_once
from . import advice, calibration
from .names import MAPS

if TYPE_CHECKING:
    from ..core.body.model import Model
    from ..core.material import Material, ModelConstants
    from ..core.mesh.surface import Mesh
    from .object_link import Floats, ObjectLink


def read_model(
    scene: bpy.types.Scene, body: bpy.types.Object, mesh: Mesh, link: ObjectLink, *, identify: str = "BACKGROUND"
) -> Model:
    """Read the materials and settings of an object into a model on the mesh that it was linked with.

    Args:
        identify: as for `read_body`.

    Raises:
        DimpleError: it cannot be pressed with them, with the reason and what to do.
    """
    found: Model = at_once(reading_model(scene, body, mesh, link, identify))
    return found


def reading_model(
    scene: bpy.types.Scene, body: bpy.types.Object, mesh: Mesh, link: ObjectLink, identify: str = "BACKGROUND"
) -> Parts:
    """Read a model in parts; see `read_model`. Blender is looked at before the first of them only."""
    from ..core.mesh.surface import base_vertices

    params, surroundings = body.dimple.to_params(), scene.dimple
    rigged = link.carried or (link.shaped and link.follows and params["pinned"] != "none")
    name, said = body.name, advice.on_body(body, mesh, scene, link.refined)
    try:
        pinned = base_vertices(mesh) if params["pinned"] == "base" else None
        if params["pinned"] == "group":
            pinned = _pins(body, params["pin_group"])
            pinned = link.refined.least_at_vertices(pinned) if link.refined else pinned
        found = [_material(body, slot, mesh, pinned, identify) for slot in link.slots]
        materials, messages = zip(*found, strict=True)
        groups = {name: params[f"{name}_group"] for name, _, _ in MAPS}
        maps = {name: _weights(body, group, name) for name, group in groups.items() if group}
        if link.refined:
            maps = {name: link.refined.at_vertices(weights) for name, weights in maps.items()}
        make = partial(
            _made, mesh, materials, pinned=pinned, **maps,
            gravity=gravity(scene) if surroundings.use_gravity else (0.0, 0.0, 0.0),
            ground=0.0 if surroundings.use_ground else None, rigged=rigged,
        )  # fmt: skip
        model: Model = yield 0.4, make
    except DimpleError as error:
        raise DimpleError(f'"{name}": {error}') from error
    notes = (*filter(None, messages), *said, *advice.on_fill(model))
    return replace(model, notes=(*model.notes, *notes))


def _made(*given: Any, **named: Any) -> Model:
    """Build a model, with what the frame of a change to it would wait for."""
    from ..core.body.model import build_model

    model = build_model(*given, **named)
    _ = model.springs.in_slots
    return model


def gravity(scene: bpy.types.Scene) -> tuple[float, ...]:
    """Return the gravity of a scene (3,) [m/s2]; none when the scene has it switched off."""
    return tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)


def _material(
    body: bpy.types.Object, slot: int, mesh: Mesh, pinned: Floats | None, identify: str
) -> tuple[Material, str]:
    """Return the constants of a body's material with those of its model, where they are known, and a note."""
    from ..core.body.estimate import between
    from ..core.material import DEFAULT_MATERIAL

    material = body.material_slots[slot].material if body.material_slots else None
    constants = DEFAULT_MATERIAL if material is None else constants_on(mesh, material)
    if constants.constants is not None or identify == "NO":
        return constants, ""
    from . import identified

    owner, note = (body.session_uid, slot), ""
    pins = None if pinned is None else np.asarray(pinned) >= 0.5

    def ask(wanted: Material) -> tuple[ModelConstants | None, str]:
        deepest = calibration.deepest(material and material.dimple, wanted.x0)
        wait = identify == "WAIT" or bpy.app.background
        return identified.model_constants(owner, mesh, wanted, deepest, pinned=pins, wait=wait)

    near = _recorded(material, mesh, constants)
    if not calibration.animated(material):
        found, note = ask(constants)
        if found is not None or note:
            return replace(constants, constants=found), note
        near = near or identified.latest(owner, mesh)  # until it is there
    known = [near] if near else []
    if calibration.animated(material) and not near:
        for values in calibration.ends_of_keyframes(material):
            end = replace(constants, **values)
            found, note = ask(end)
            if found is None:  # in the background one is looked for at a time
                break
            known.append(replace(end, constants=found))
    return replace(constants, constants=between(known, constants, mesh.size)), note


def _recorded(material: bpy.types.Material | None, mesh: Mesh, constants: Material) -> Material | None:
    """Return what was identified on a mesh and is kept in a material, None where that says nothing of it now."""
    from ..core.material import ModelConstants

    measured = material and calibration.identified_for(material.dimple, mesh)
    known = material and material.dimple.to_params().get("constants")
    return replace(constants, **measured, constants=known) if measured and isinstance(known, ModelConstants) else None


def constants_on(mesh: Mesh, material: bpy.types.Material) -> Material:
    """Return the constants of a material on a mesh; without its model constants where they do not hold there.

    Raises:
        DimpleError: a constant is out of its range.
    """
    from ..core.material import Material

    try:
        constants = Material(**material.dimple.to_params())
    except DimpleError as error:
        raise DimpleError(f'material "{material.name}": {error}') from error
    if constants.constants is not None and calibration.changed(material.dimple, mesh):
        return replace(constants, constants=None)
    return constants


def _pins(body: bpy.types.Object, group: str) -> Floats:
    if not group:
        raise DimpleError("it is pinned by a vertex group, but none is chosen. Choose one in Physics > Dimple.")
    weights = _weights(body, group, "pin")
    if not (weights >= 0.5).any():
        raise DimpleError(f'no vertex of the pin group "{group}" has a weight of 0.5 or more. Paint some.')
    return weights


def _weights(body: bpy.types.Object, group: str, role: str) -> Floats:
    """Return the weight (N,) of every vertex in a vertex group, 0 outside it; or a float attribute of that name."""
    found, attribute = body.vertex_groups.get(group), body.data.attributes.get(group)
    if found is None and attribute and attribute.domain == "POINT" and attribute.data_type == "FLOAT":
        values = np.empty(len(body.data.vertices), np.float32)
        attribute.data.foreach_get("value", values)
        return values.astype(np.float64)
    if found is None:
        raise DimpleError(f'there is no vertex group "{group}" ({role}). Choose another in Physics > Dimple.')
    import bmesh

    read = bmesh.new()  # half the time of vertex.groups: a dictionary a vertex
    try:
        read.from_mesh(body.data, face_normals=False, vertex_normals=False)
        layer, index = read.verts.layers.deform.active, found.index
        return np.array([vertex[layer].get(index, 0.0) if layer else 0.0 for vertex in read.verts])
    finally:
        read.free()
