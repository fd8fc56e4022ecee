"""The bridge between Blender's objects and the core: what is read of an object to press it.

With `object_link`, `bridge_model`, `bridge_write`, `rest_shape` and `offset` the only toucher of mesh arrays and scale.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
import numpy.typing as npt

from ..core.base import FARTHEST, DimpleError
from ..core.steps import Parts, at_once
from . import bridge_model, rest_shape, stack
from .object_link import Floats as Floats
from .object_link import ObjectLink as ObjectLink
from .object_link import Singles as Singles
from .object_link import check_matrix as check_matrix
from .object_link import get_points as get_points
from .object_link import offsets_of as offsets_of
from .object_link import places as places
from .object_link import to_local as to_local
from .object_link import to_physical as to_physical

if TYPE_CHECKING:
    from ..core.body.model import Model
    from ..core.mesh.refine import Refinement
    from ..core.mesh.surface import Mesh

LEVEL = 1e-4  # of its size: points of an object as high as its highest one
_CONVERTIBLE = {"CURVE", "SURFACE", "META", "FONT"}  # Blender turns them into meshes that have faces

def read_body(context: bpy.types.Context, body: bpy.types.Object, **options: Any) -> tuple[ObjectLink, Model]:
    """Read a mesh object at once; see `reading_body`."""
    found: tuple[ObjectLink, Model] = at_once(reading_body(context, body, **options))
    return found


def reading_body(
    context: bpy.types.Context,
    body: bpy.types.Object,
    *,
    baked: bool = True,
    refined: Refinement | None = None,
) -> Parts:
    """Read a mesh object with its materials and settings into a link and a model, in parts; change nothing.

    Args:
        baked: take the shape keys of an earlier bake as part of the rest shape.
        refined: how its surface was cut finer before; None cuts it where it is too coarse for a fingertip.

    Raises:
        DimpleError: this object cannot be pressed, with the reason and what to do.
    """
    from ..core.mesh.surface import mesh_from_triangles

    check(body)
    context.view_layer.update()
    shape, matrix = rest_shape.read(context, body, baked=baked), np.array(body.matrix_world)
    rest = shape.points
    scale = _scale(context.scene, body.name, rest, matrix, body.dimple.to_params()["size"])
    triangles, slots = _triangles(body.data)
    if np.linalg.det(matrix[:3, :3]) < 0:  # mirrored: what looked outward looks inward
        triangles = triangles[:, ::-1]
    used, triangle_material = np.unique(np.clip(slots, 0, max(len(body.material_slots) - 1, 0)), return_inverse=True)
    points = to_physical(scale, matrix, rest)
    if refined is None or refined.before != len(rest):
        refined = yield 0.0, _refining(context.scene, body, points, triangles, triangle_material)
    if refined:
        points, triangles = refined.at_vertices(points), refined.triangles
        triangle_material = triangle_material[refined.origin]
    try:
        make = partial(mesh_from_triangles, points, triangles, triangle_material=triangle_material)
        mesh: Mesh = yield 0.1, make
    except DimpleError as error:
        raise DimpleError(f'"{body.name}": {error}') from error
    resting = mesh.rest_positions[mesh.source][: len(rest)].astype(np.float32)
    link = ObjectLink(
        uid=body.session_uid, name=body.name, rest=rest, scale=scale, matrix=matrix, resting=resting,
        rounding=float(4 * np.finfo(np.float32).eps * np.abs(resting).max()), slots=tuple(map(int, used)),
        refined=refined, shaped=shape.shaped, follows=shape.follows,
        carried=shape.follows and stack.is_carried(body),
    )  # fmt: skip
    model = yield from bridge_model.reading_model(context.scene, body, mesh, link)
    return link, replace(model, notes=(*model.notes, shape.note)) if shape.note else model


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
        if len(body.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.polygons):
            raise DimpleError(f'"{body.name}" has its faces from a modifier alone. Apply that modifier first.')
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
    """Raise a DimpleError when an object may not be given a modifier."""
    if body.library:
        raise DimpleError(f'"{body.name}" is linked from another file. Make it local first: Object > Relations.')


def find(uid: int, name: str = "") -> bpy.types.Object | None:
    """Return the object with a session_uid, looked for first under the name it had."""
    named = bpy.data.objects.get(name)
    if named and named.session_uid == uid:
        return named
    return next((candidate for candidate in bpy.data.objects if candidate.session_uid == uid), None)


def scale_and_top(context: bpy.types.Context, body: bpy.types.Object) -> tuple[float, Floats]:
    """Return physical metres per scene unit of an object, and in the scene the middle (3,) of its highest points."""
    context.view_layer.update()
    rest, matrix = rest_shape.read(context, body).points, np.array(body.matrix_world)
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
    if not np.isfinite(rest).all():
        bad = np.flatnonzero(~np.isfinite(rest).all(axis=1))
        raise DimpleError(
            f'"{name}": vertex {bad[0]} has a coordinate that is not a number ({len(bad)} such vertices). '
            "Delete or move them."
        )
    check_matrix(name, matrix)
    axes = np.linalg.norm(matrix[:3, :3], axis=0)
    largest = float((np.array([np.ptp(along) for along in rest.T]) * axes).max())  # axis by axis is far faster
    if largest <= 0:
        raise DimpleError(f'"{name}": all vertices lie in one point. Give the mesh a size.')
    if size is not None and not size <= FARTHEST:
        raise DimpleError(f'"{name}": a Custom Size of {1e3 * size:.3g} mm is too large. Lower it in Physics > Dimple.')
    return float(scene.unit_settings.scale_length) if size is None else size / largest


def _refining(
    scene: bpy.types.Scene, body: bpy.types.Object, points: Floats, triangles: npt.NDArray[Any], kinds: npt.NDArray[Any]
) -> Callable[[], Refinement | None]:
    """Return what cuts a surface (N, 3) [m] finer; it returns None where that is fine enough or simulated as it is."""
    from ..core.mesh.refine import is_coarse, refine

    radius = scene.dimple.finger_radius_mm / 1e3
    as_it_is = body.dimple.simulated != "AUTO"

    def refined() -> Refinement | None:
        if as_it_is or not is_coarse(points, triangles, radius):
            return None
        found = refine(points, triangles, kinds, radius)
        return found if found.rounds else None

    return refined


def _triangles(mesh: bpy.types.Mesh) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Return the triangles (t, 3) of a mesh and the material slot of each (t,).

    Only the corners are asked for one by one, which takes 0.3 s for a million: a polygon's triangles follow each other.
    """
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    begins = np.empty(len(mesh.polygons), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    mesh.polygons.foreach_get("loop_start", begins)
    slots = np.zeros(len(mesh.polygons), np.int32)
    if given := mesh.attributes.get("material_index"):
        given.data.foreach_get("value", slots)
    return corners.reshape(-1, 3), np.repeat(slots, np.diff(begins, append=len(mesh.loops)) - 2)
