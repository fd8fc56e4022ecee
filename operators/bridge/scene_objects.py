"""Read an object of Blender into a model that can be pressed."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ...core.background_work import Parts, at_once
from ...core.base import DimpleError
from ...core.message import Message, about, in_a_row
from . import body_model, final_mesh, modifier_kinds
from .object_link import Floats, ObjectLink, Singles, get_points, scale_of_body, to_physical

if TYPE_CHECKING:
    from ...core.body.model import Model
    from ...core.mesh.surface import Mesh

LEVEL = 1e-4  # fraction of an object's size: points this close to its highest level count as highest
_CONVERTIBLE = {"CURVE", "SURFACE", "META", "FONT"}  # types that Blender converts to meshes with faces


def read_body(context: bpy.types.Context, body: bpy.types.Object, **options: Any) -> tuple[ObjectLink, Model]:
    """Read a mesh object in one go; see `reading_body`."""
    return at_once(reading_body(context, body, **options))


def reading_body(
    context: bpy.types.Context,
    body: bpy.types.Object,
    *,
    cuts: int | None = None,
) -> Parts:
    """Read a mesh object with its materials and settings into a link and a model, in parts; change nothing.

    Args:
        cuts: number of subdivisions of its final mesh; None: as many as the fingertip needs.

    Raises:
        DimpleError: the object cannot be pressed; the message says why, and what to do.
    """
    check(body)
    context.view_layer.update()
    matrix = np.array(body.matrix_world)
    rest, triangles, slots, cuts = final_mesh.read(context, body, cuts=cuts)
    scale = scale_of_body(context.scene, body, rest, matrix)
    if np.linalg.det(matrix[:3, :3]) < 0:  # mirrored: make the triangles face outward again
        triangles = triangles[:, ::-1]
    used, triangle_material = np.unique(np.clip(slots, 0, max(len(body.material_slots) - 1, 0)), return_inverse=True)
    try:
        mesh: Mesh = yield 0.1, partial(_mesh, scale, matrix, rest, triangles, triangle_material)
    except DimpleError as error:
        raise DimpleError(about(body.name, str(error))) from error
    resting = mesh.rest_positions[mesh.source].astype(np.float32)
    pinned = body.dimple.pinned
    link = ObjectLink(
        uid=body.session_uid, name=body.name, rest=rest, scale=scale, matrix=matrix, resting=resting, cuts=cuts,
        own=get_points(body.data.attributes["position"].data, len(body.data.vertices), "vector"),
        rounding=float(4 * np.finfo(np.float32).eps * np.abs(resting).max()), slots=tuple(map(int, used)),
        bones=scale * np.array(modifier_kinds.bones_of(body)).reshape(-1, 2, 3), shaped=modifier_kinds.is_shaped(body),
        rigged=modifier_kinds.is_carried(body) or (modifier_kinds.is_deformed(body) and pinned),
    )  # fmt: skip
    model: Model = yield from body_model.reading_model(context.scene, body, mesh, link)
    return link, model


def _mesh(scale: float, matrix: Floats, rest: Singles, triangles: Any, triangle_material: Any) -> Mesh:
    from ...core.mesh.surface import mesh_from_triangles

    points = to_physical(scale, matrix, rest)
    return mesh_from_triangles(points, triangles, triangle_material=triangle_material)


def check(body: bpy.types.Object) -> None:
    """Raise a DimpleError when an object is not a mesh in Object Mode."""
    if body.type != "MESH":
        raise DimpleError(_not_a_mesh(body))
    if body.mode != "OBJECT":
        raise DimpleError('"{name}" is being edited. Go back to Object Mode first.', name=body.name)


def _not_a_mesh(body: bpy.types.Object) -> str:
    """Return a message that an object is not a mesh, and what to do."""
    if body.type == "EMPTY" and body.instance_type == "COLLECTION":
        return Message(
            '"{name}" is a collection instance, not a mesh. Make its objects real first: Object > Apply > Make '
            "Instances Real.",
            name=body.name,
        )
    what = "Make Soft converts it to a mesh." if body.type in _CONVERTIBLE else "Select a mesh to press."
    return in_a_row([Message('"{name}" is not a mesh.', name=body.name), what])


def metres_per_unit(scene: bpy.types.Scene) -> float:
    """Return the length of a scene's unit [m]; without units it is a metre, as for Blender's exporters."""
    return 1.0 if scene.unit_settings.system == "NONE" else scene.unit_settings.scale_length


def check_writable(body: bpy.types.Object) -> None:
    """Raise a DimpleError if an object cannot be given a modifier."""
    if body.library:
        raise DimpleError(
            '"{name}" is linked from another file. Make it local first: Object > Relations.', name=body.name
        )


def scale_and_top(context: bpy.types.Context, body: bpy.types.Object) -> tuple[float, Floats]:
    """Return physical metres per scene unit of an object, and its highest vertex (3,) in the scene, or the middle one
    if several are equally high.
    """
    context.view_layer.update()
    rest, matrix = final_mesh.read(context, body).points, np.array(body.matrix_world)
    scale = scale_of_body(context.scene, body, rest, matrix)
    world = to_physical(1.0, matrix, rest)
    height = world[:, 2]
    highest = world[height >= height.max() - LEVEL * np.ptp(world, axis=0).max()]
    return scale, highest[((highest - highest.mean(axis=0)) ** 2).sum(axis=1).argmin()]


def nearest_final(link: ObjectLink) -> list[int]:
    """Return the index of the nearest vertex of the final mesh for each vertex of an object's own mesh."""
    from mathutils.kdtree import KDTree

    tree = KDTree(len(link.rest))
    for number, point in enumerate(link.rest.tolist()):
        tree.insert(point, number)
    tree.balance()
    return [tree.find(point)[1] for point in link.own.tolist()]
