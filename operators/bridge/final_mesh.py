"""The final mesh of an object, after shape keys and modifiers: the surface that is seen and pressed.

If it is too coarse for the fingertip, the modifier that shows the press subdivides it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy
import numpy as np
import numpy.typing as npt

from ...core.base import DimpleError
from ..names import CACHES_OFF, PRESS, REST
from . import press_modifier
from .modifier_kinds import is_cache
from .object_link import find, get_points, scale_of_body

if TYPE_CHECKING:
    from .object_link import Floats, ObjectLink, Singles

WIDE = 0.75  # [fingertip radii] in faces wider than this a dent shows facets, and a narrow one a dark corner
SHARE = 0.05  # fraction of the surface that may lie in wider faces
MOST = 20_000  # [vertices] largest mesh made by subdividing: a larger one does not run live


class Final(NamedTuple):
    """A final mesh at rest, subdivided as the modifier does."""

    points: Singles  # (N, 3) coordinates in the object's space
    triangles: np.ndarray  # (t, 3)
    slots: np.ndarray  # (t,) material slot of each triangle
    cuts: int  # number of subdivisions


@contextmanager
def attached(context: bpy.types.Context, body: bpy.types.Object, cuts: int | None = None) -> Iterator[None]:
    """Give an object the modifier that shows a press within the context, unless it has it already. A hidden object is
    shown meanwhile, so that it is evaluated.
    """
    if press_modifier.modifier_of(body):
        yield
        return
    hidden, hidden_here = body.hide_viewport, body.name in context.view_layer.objects and body.hide_get()
    if hidden:
        body.hide_viewport = False
    if hidden_here:
        body.hide_set(False)
    uid, name = body.session_uid, body.name
    try:
        attach(context, body, cuts)
        yield
    finally:
        if there := find(uid, name):  # it may have been deleted, or replaced by an undo
            detach(there)
            there.hide_viewport = hidden
            if hidden_here:
                there.hide_set(True)


def attach(context: bpy.types.Context, body: bpy.types.Object, cuts: int | None = None) -> None:
    """Give an object the modifier that shows a press, unless it has it already, and switch its bakes off.

    Args:
        cuts: number of subdivisions; None: as many as the fingertip needs.
    """
    if press_modifier.modifier_of(body):
        return
    shown = [modifier for modifier in body.modifiers if is_cache(modifier) and modifier.show_viewport]
    for modifier in shown:
        modifier.show_viewport = False
    if shown:
        body[CACHES_OFF] = "\n".join(modifier.name for modifier in shown)  # stored here, so that duplicates have it too
    try:
        mesh = evaluated(context, body)
        given, cuts = len(mesh.vertices), cuts_of(context, body, mesh) if cuts is None else cuts
        shown = press_modifier.Shown(given, cuts, press_modifier.new_carrier())
        press_modifier.add(body, "Dimple Press", PRESS, [shown])
    except BaseException:
        detach(body)
        raise


def detach(body: bpy.types.Object) -> None:
    """Remove the modifier that shows a press, and switch the bakes on again."""
    press_modifier.remove(body, PRESS)
    for name in str(body.pop(CACHES_OFF, "")).split("\n"):
        if name in body.modifiers:
            body.modifiers[name].show_viewport = True


def read(context: bpy.types.Context, body: bpy.types.Object, *, cuts: int | None = None) -> Final:
    """Return the final mesh of an object at rest now; change nothing.

    Args:
        cuts: number of subdivisions; None: as many as the fingertip needs.

    Raises:
        DimpleError: the object has no faces, or is not in the view layer.
    """
    if body.name not in context.view_layer.objects:
        raise DimpleError(
            '"{name}" is not in this view layer, so it cannot be read. Add it there first.', name=body.name
        )
    with attached(context, body, cuts):
        mesh = evaluated(context, body)
        rest = read_rest(body, context.evaluated_depsgraph_get())
        if rest is None or not len(mesh.polygons):
            raise DimpleError(
                '"{name}" has no faces, so there is no surface to press. Add faces first.', name=body.name
            )
        return Final(rest, *triangles_of(mesh), _cuts_now(body))


def _cuts_now(body: bpy.types.Object) -> int:
    modifier = press_modifier.modifier_of(body)
    nodes = modifier.node_group.nodes if modifier else ()
    return next((each.inputs["Level"].default_value for each in nodes if each.type == "SUBDIVIDE_MESH"), 0)


def weights(context: bpy.types.Context, body: bpy.types.Object, group: str, cuts: int) -> Floats | None:
    """Return the weight (N,) of each vertex of the final mesh in a vertex group, 0 outside it, or the float attribute
    of that name; None if there is neither.
    """
    found = body.vertex_groups.get(group)
    with attached(context, body, cuts):
        mesh = evaluated(context, body)
        attribute = mesh.attributes.get(group)
        if found is None and attribute and attribute.domain == "POINT" and attribute.data_type == "FLOAT":
            values = np.empty(len(mesh.vertices), np.float32)
            attribute.data.foreach_get("value", values)
            return values.astype(np.float64)
        if found is None:
            return None
        import bmesh

        read = bmesh.new()  # gives a dictionary per vertex in half the time of vertex.groups
        try:
            read.from_mesh(mesh, face_normals=False, vertex_normals=False)
            layer, index = read.verts.layers.deform.active, found.index
            return np.array([vertex[layer].get(index, 0.0) if layer else 0.0 for vertex in read.verts])
        finally:
            read.free()


def read_rest(body: bpy.types.Object, graph: bpy.types.Depsgraph) -> Singles | None:
    """Return the final mesh (N, 3) at rest in this frame; None if it is not evaluated, or if its number of vertices is
    not that for which the modifier that shows a press was made.
    """
    attribute = body.evaluated_get(graph).data.attributes.get(REST)
    return None if attribute is None else get_points(attribute.data, len(attribute.data), "vector")


def rest_now(context: bpy.types.Context, body: bpy.types.Object, link: ObjectLink, before: Singles) -> Singles:
    """Return the shape at rest (N, 3) of an object in the pose of its rig; `before` itself if it has not changed.

    Raises:
        DimpleError: its modifiers now give another number of vertices.
    """
    if not link.shaped:
        return before
    now = read_rest(body, context.evaluated_depsgraph_get())
    if now is None or len(now) != len(before):
        _check_count(context, body, link)
        return before
    return before if np.array_equal(now, before) else now


def is_stretched(matrix: Floats, before: Floats) -> bool:
    """Return whether a matrix (4, 4) scales or shears differently from an earlier one."""
    now, then = (m[:3, :3].T @ m[:3, :3] for m in (matrix, before))
    return not np.allclose(now, then, rtol=1e-6, atol=1e-12)


def _check_count(context: bpy.types.Context, body: bpy.types.Object, link: ObjectLink) -> None:
    """Raise a DimpleError if an object is visible and its number of vertices differs from that when it was read."""
    count = len(evaluated(context, body).vertices)
    if body.visible_get() and count != len(link.rest):
        raise DimpleError(
            'The modifiers of "{name}" now make {count:,} vertices instead of {vertices:,}. The number must not '
            "change while a body is pressed or baked: apply the modifier that changes it, or turn it off.",
            name=body.name, count=count, vertices=len(link.rest)
        )  # fmt: skip


def cuts_of(context: bpy.types.Context, body: bpy.types.Object, mesh: bpy.types.Mesh) -> int:
    """Return the number of subdivisions, each of which halves all edges, that make the final mesh of a body fine enough
    for the fingertip, as far as MOST permits; 0 unless the artist lets Dimple choose what to simulate.
    """
    radius = context.scene.dimple.finger_radius_mm / 1e3
    if body.dimple.simulated != "AUTO" or not 0 < len(mesh.loops) <= MOST:
        return 0
    matrix, points = np.array(body.matrix_world), points_of(mesh)
    scale = scale_of_body(context.scene, body, points, matrix)
    widths, areas = _widths(mesh, scale * points.astype(np.float64) @ matrix[:3, :3].T)
    cuts = 0
    while areas[widths > 2**cuts * WIDE * radius].sum() > SHARE * areas.sum() and len(mesh.loops) * 4**cuts <= MOST:
        cuts += 1
    return cuts


def _widths(mesh: bpy.types.Mesh, points: Floats) -> tuple[Floats, Floats]:
    """Return the width (f,) of each face, which halves when all edges are halved, and its area (f,)."""
    count, corners = np.empty(len(mesh.polygons), np.int32), corners_of(mesh)
    mesh.polygons.foreach_get("loop_total", count)
    starts = np.cumsum(count) - count
    following = np.arange(1, len(corners) + 1)
    following[starts + count - 1] = starts
    a = points[corners]
    b, centre = a[following], np.repeat(np.add.reduceat(a, starts) / count[:, None], count, axis=0)
    edges, arms = np.linalg.norm(b - a, axis=1), 2 * np.linalg.norm((a + b) / 2 - centre, axis=1)
    across = np.linalg.norm(np.cross(a - centre, b - centre), axis=1) / 2
    return np.maximum.reduceat(np.maximum(edges, arms), starts), np.add.reduceat(across, starts)


def evaluated(context: bpy.types.Context, body: bpy.types.Object) -> bpy.types.Mesh:
    """Return the mesh of an object after all its modifiers."""
    context.view_layer.update()
    return body.evaluated_get(context.evaluated_depsgraph_get()).data


def points_of(mesh: bpy.types.Mesh) -> Singles:
    """Return the coordinates (N, 3) of a mesh."""
    return get_points(mesh.vertices, len(mesh.vertices), "co")


def corners_of(mesh: bpy.types.Mesh) -> npt.NDArray[np.int32]:
    """Return the vertex index at each corner of the faces of a mesh."""
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return corners


def triangles_of(mesh: bpy.types.Mesh) -> tuple[Any, Any]:
    """Return the triangles (t, 3) of a mesh and the material slot of each (t,).

    Only the vertices of the triangles are read one by one, 0.3 s for a million. Their polygons need not be read,
    because the triangles of a polygon are consecutive.
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
