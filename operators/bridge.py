"""The bridge between Blender's objects and the core: the only toucher of mesh arrays and world scale.

A session lives in metres of the real object, on the axes and the origin of Blender's world: p = s M co, with M the
object's matrix and s its physical size over its size in the scene. What is kept here are numbers and session_uids,
never references into Blender's data, which an undo replaces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
import numpy.typing as npt

from ..core.base import FARTHEST, DimpleError
from . import advice, calibration
from .names import BAKED_KEY, LIVE_KEY, MAPS, REST

if TYPE_CHECKING:
    from ..core.body.model import Model
    from ..core.material import Material
    from ..core.mesh.refine import Refinement
    from ..core.mesh.surface import Mesh

LEVEL = 1e-4  # of its size: points of an object as high as its highest one
_CONVERTIBLE = {"CURVE", "SURFACE", "META", "FONT"}  # Blender turns them into meshes that have faces

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectLink:
    """What joins an object to its session.

    uid, name: of the object.
    rest: (N, 3) its coordinates at rest, bit for bit.
    scale: physical metres per scene unit.
    matrix: (4, 4) of the object at the start.
    resting: (N, 3) what a frame shows at rest [m].
    rounding: what a vertex at rest may be off it [m].
    slots: of the object's materials that the model has.
    refined: how the surface that is pressed was cut finer than the object's own; None where it was not.
    """

    uid: int
    name: str
    rest: Singles
    scale: float
    matrix: Floats
    resting: Singles
    rounding: float
    slots: tuple[int, ...]
    refined: Refinement | None = None


def read_body(
    context: bpy.types.Context,
    body: bpy.types.Object,
    *,
    baked: bool = True,
    identify: str = "BACKGROUND",
    refined: Refinement | None = None,
) -> tuple[ObjectLink, Model]:
    """Read a mesh object with its materials and settings into a model; change nothing.

    Args:
        baked: take the shape keys of an earlier bake as part of the rest shape.
        identify: what is done about model constants that are not known yet: "BACKGROUND" (they come later), "WAIT"
            (they are found now) or "NO" (the closed form takes their place).
        refined: how its surface was cut finer before; None cuts it where it is too coarse for a fingertip.

    Raises:
        DimpleError: this object cannot be pressed, with the reason and what to do.
    """
    from ..core.mesh.surface import mesh_from_triangles

    check(body)
    context.view_layer.update()
    rest, matrix = rest_coordinates(body, baked=baked), np.array(body.matrix_world)
    scale = _scale(context.scene, body.name, rest, matrix, body.dimple.to_params()["size"])
    triangles, slots = _triangles(body.data)
    if np.linalg.det(matrix[:3, :3]) < 0:  # mirrored: what looked outward looks inward
        triangles = triangles[:, ::-1]
    used, triangle_material = np.unique(np.clip(slots, 0, max(len(body.material_slots) - 1, 0)), return_inverse=True)
    points = to_physical(scale, matrix, rest)
    if refined is None or refined.before != len(rest):
        refined = _refined(context.scene, body, points, triangles, triangle_material)
    if refined:
        points, triangles = refined.at_vertices(points), refined.triangles
        triangle_material = triangle_material[refined.origin]
    try:
        mesh = mesh_from_triangles(points, triangles, triangle_material=triangle_material)
    except DimpleError as error:
        raise DimpleError(f'"{body.name}": {error}') from error
    resting = mesh.rest_positions[mesh.source][: len(rest)].astype(np.float32)
    link = ObjectLink(
        uid=body.session_uid, name=body.name, rest=rest, scale=scale, matrix=matrix, resting=resting,
        rounding=float(4 * np.finfo(np.float32).eps * np.abs(resting).max()), slots=tuple(map(int, used)),
        refined=refined,
    )  # fmt: skip
    return link, read_model(context.scene, body, mesh, link, identify=identify)


def read_model(
    scene: bpy.types.Scene, body: bpy.types.Object, mesh: Mesh, link: ObjectLink, *, identify: str = "BACKGROUND"
) -> Model:
    """Read the materials and settings of an object into a model on the mesh that it was linked with.

    Args:
        identify: as for `read_body`.

    Raises:
        DimpleError: it cannot be pressed with them, with the reason and what to do.
    """
    from ..core.body.model import build_model
    from ..core.mesh.surface import base_vertices

    params, surroundings = body.dimple.to_params(), scene.dimple
    try:
        held = base_vertices(mesh) if params["pinned"] == "base" else None
        if params["pinned"] == "group":
            held = _pins(body, params["pin_group"])
            held = link.refined.least_at_vertices(held) if link.refined else held
        if params["law_set"] == "paper":  # its equations have no model constants
            identify = "NO"
        found = [_material(body, slot, mesh, held, identify) for slot in link.slots]
        materials, messages = zip(*found, strict=True)
        groups = {name: params[f"{name}_group"] for name, _, _ in MAPS}
        maps = {name: _weights(body, group, name) for name, group in groups.items() if group}
        if link.refined:
            maps = {name: link.refined.at_vertices(weights) for name, weights in maps.items()}
        model = build_model(
            mesh, materials, law_set=params["law_set"], held=held, **maps,
            gravity=gravity(scene) if surroundings.use_gravity else (0.0, 0.0, 0.0),
            ground=0.0 if surroundings.use_ground else None,
        )  # fmt: skip
    except DimpleError as error:
        raise DimpleError(f'"{body.name}": {error}') from error
    notes = (*filter(None, messages), *advice.on_body(body, mesh, scene, link.refined), *advice.on_fill(model))
    return replace(model, notes=(*model.notes, *notes))


def scale_of(scene: bpy.types.Scene, body: bpy.types.Object, link: ObjectLink) -> float:
    """Return physical metres per scene unit of a running body by the settings it has now.

    Raises:
        DimpleError: it has no size.
    """
    return _scale(scene, body.name, link.rest, link.matrix, body.dimple.to_params()["size"])


def check(body: bpy.types.Object) -> None:
    """Raise a DimpleError when an object is not a mesh in Object Mode with a surface."""
    if body.type != "MESH":
        raise DimpleError(_not_a_mesh(body))
    if body.mode != "OBJECT":
        raise DimpleError(f'"{body.name}" is being edited. Go back to Object Mode first.')
    if not len(body.data.polygons):
        raise DimpleError(f'"{body.name}" has no faces, so there is no surface to press. Add faces first.')


def _not_a_mesh(body: bpy.types.Object) -> str:
    """Return the sentence that says what an object is instead, and what to do."""
    if body.type == "EMPTY" and body.instance_type == "COLLECTION":
        return (
            f'"{body.name}" is a collection instance, not a mesh. '
            "Make its objects real first: Object > Apply > Make Instances Real."
        )
    kind = body.bl_rna.properties["type"].enum_items[body.type].name.lower()
    article = "an" if kind[0] in "aeiou" else "a"
    todo = "Make Soft converts it to a mesh." if body.type in _CONVERTIBLE else "Select a mesh to press."
    return f'"{body.name}" is {article} {kind}, not a mesh. {todo}'


def check_writable(body: bpy.types.Object) -> None:
    """Raise a DimpleError when the mesh of an object may not be changed."""
    if body.library or body.data.library:
        raise DimpleError(f'"{body.name}" is linked from another file. Make it local first: Object > Relations.')
    keys = body.data.shape_keys
    if keys and not keys.use_relative:
        raise DimpleError(f'"{body.name}" has absolute shape keys. Switch its shape keys to Relative first.')
    if keys and body.show_only_shape_key:
        raise DimpleError(f'"{body.name}" shows one shape key only. Switch Solo Active Shape Key off first.')


def check_matrix(name: str, matrix: Floats) -> None:
    """Raise a DimpleError when the matrix (4, 4) of an object has no inverse."""
    longest = np.linalg.norm(matrix[:3, :3], axis=0).max()
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3])) <= 1e-9 * longest**3:
        raise DimpleError(f'"{name}" has a scale of 0, so it is flat or a point. Give it a scale in the sidebar.')


def gravity(scene: bpy.types.Scene) -> tuple[float, ...]:
    """Return the gravity of a scene (3,) [m/s2]; none when the scene has it switched off."""
    return tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)


def find(uid: int, name: str = "") -> bpy.types.Object | None:
    """Return the object with a session_uid, looked for first under the name it had."""
    named = bpy.data.objects.get(name)
    if named and named.session_uid == uid:
        return named
    return next((candidate for candidate in bpy.data.objects if candidate.session_uid == uid), None)


def get_points(points: Any, count: int, name: str) -> Singles:
    """Read coordinates (count, 3) from a collection of Blender's."""
    coordinates = np.empty(3 * count, np.float32)
    points.foreach_get(name, coordinates)
    return coordinates.reshape(-1, 3)


def rest_coordinates(body: bpy.types.Object, *, baked: bool = True) -> Singles:
    """Return the coordinates (N, 3) of a mesh with its shape keys mixed, before modifiers."""
    mesh = body.data
    count, keys = len(mesh.vertices), mesh.shape_keys
    if not keys:
        shown = REST if REST in mesh.attributes else "position"  # the session of an object that shares it shows on it
        return get_points(mesh.attributes[shown].data, count, "vector")
    shapes = {key.name: get_points(key.points, count, "co") for key in keys.key_blocks}
    rest = shapes[keys.reference_key.name].copy()
    for key in keys.key_blocks[1:]:
        ours = key.name == LIVE_KEY or (key.name.startswith(BAKED_KEY) and not baked)
        if not ours and not key.mute and key.value:
            share = np.float32(key.value) * (shapes[key.name] - shapes[key.relative_key.name])
            weights = _weights(body, key.vertex_group, "shape key") if key.vertex_group else np.ones(count)
            rest += weights[:, None].astype(np.float32) * share
    return rest


def to_physical(scale: float, matrix: Floats, local: npt.NDArray[Any]) -> Floats:
    """Return points (n, 3) of an object with a matrix as physical ones [m]."""
    return scale * (local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def places(link: ObjectLink, matrix: Floats) -> Floats:
    """Return where every input vertex of a session (n, 3) [m] is at rest, with its object there."""
    points = to_physical(link.scale, matrix, link.rest)
    return link.refined.at_vertices(points) if link.refined else points


def to_local(link: ObjectLink, matrix: Floats, physical: Singles) -> Singles:
    """Return the points of a session (n, 3) [m] as coordinates (N, 3) of its object.

    Vertices at rest get their very bits back. Of a surface that was cut finer the object's own come first.
    """
    physical = physical[: len(link.rest)]
    inverse = np.linalg.inv(matrix)
    local = (physical @ (inverse[:3, :3].T / link.scale) + inverse[:3, 3]).astype(np.float32)
    if np.array_equal(matrix, link.matrix):
        x, y, z = (np.abs(physical - link.resting) <= link.rounding).T
        resting = np.flatnonzero(x & y & z)
        local[resting] = link.rest[resting]
    return local


def scale_and_top(context: bpy.types.Context, body: bpy.types.Object) -> tuple[float, Floats]:
    """Return physical metres per scene unit of an object, and in the scene the middle (3,) of its highest points."""
    context.view_layer.update()
    rest, matrix = rest_coordinates(body), np.array(body.matrix_world)
    scale = _scale(context.scene, body.name, rest, matrix, body.dimple.to_params()["size"])
    world = to_physical(1.0, matrix, rest)
    height = world[:, 2]
    highest = world[height >= height.max() - LEVEL * np.ptp(world, axis=0).max()]
    return scale, highest[((highest - highest.mean(axis=0)) ** 2).sum(axis=1).argmin()]


def _scale(scene: bpy.types.Scene, name: str, rest: Singles, matrix: Floats, size: float | None) -> float:
    """Return physical metres per scene unit.

    Args:
        size: the largest dimension of the real object [m], None when it is as large as modelled.
    """
    bad = np.flatnonzero(~np.isfinite(rest).all(axis=1))
    if len(bad):
        raise DimpleError(
            f'"{name}": vertex {bad[0]} has a coordinate that is not a number ({len(bad)} such vertices). '
            "Delete or move them."
        )
    check_matrix(name, matrix)
    axes = np.linalg.norm(matrix[:3, :3], axis=0)
    largest = float((np.ptp(rest, axis=0) * axes).max())
    if largest <= 0:
        raise DimpleError(f'"{name}": all vertices lie in one point. Give the mesh a size.')
    if size is not None and not size <= FARTHEST:
        raise DimpleError(f'"{name}": a Custom Size of {1e3 * size:.3g} mm is too large. Lower it in Physics > Dimple.')
    return float(scene.unit_settings.scale_length) if size is None else size / largest


def _refined(
    scene: bpy.types.Scene, body: bpy.types.Object, points: Floats, triangles: npt.NDArray[Any], kinds: npt.NDArray[Any]
) -> Refinement | None:
    """Return how a surface (N, 3) [m] is cut finer, None where it is fine enough or simulated as it is."""
    from ..core.mesh.refine import is_coarse, refine

    radius = scene.dimple.finger_radius_mm / 1e3
    if body.dimple.simulated != "AUTO" or body.dimple.to_params()["law_set"] == "paper":
        return None
    found = refine(points, triangles, kinds, radius) if is_coarse(points, triangles, radius) else None
    return found if found and found.rounds else None


def _triangles(mesh: bpy.types.Mesh) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Return the triangles (t, 3) of a mesh and the material slot of each (t,)."""
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    polygons = np.empty(len(mesh.loop_triangles), np.int32)
    slots = np.empty(len(mesh.polygons), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    mesh.loop_triangles.foreach_get("polygon_index", polygons)
    mesh.polygons.foreach_get("material_index", slots)
    return corners.reshape(-1, 3), slots[polygons]


def _material(
    body: bpy.types.Object, slot: int, mesh: Mesh, held: Floats | None, identify: str
) -> tuple[Material, str]:
    """Return the constants of a body's material with those of its model, where they are known, and a note."""
    from ..core.material import DEFAULT_MATERIAL

    material = body.material_slots[slot].material if body.material_slots else None
    constants = DEFAULT_MATERIAL if material is None else constants_on(mesh, material)
    if constants.constants is not None or identify == "NO" or calibration.animated(material):
        return constants, ""
    from . import identified

    deepest = calibration.deepest(material and material.dimple, constants.x0)
    wait = identify == "WAIT" or bpy.app.background
    pins = None if held is None else np.asarray(held) >= 0.5
    found, note = identified.model_constants(
        (body.session_uid, slot), mesh, constants, deepest, held=pins, wait=wait
    )
    return replace(constants, constants=found), note


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
        raise DimpleError("it is held by a vertex group, but none is chosen. Choose one in Physics > Dimple.")
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
