"""The rest shape of a mesh that shows a session: carried in an attribute, put back, and changed as the artist edits.

Part of the bridge: with `bridge` and `bridge_write` the only toucher of mesh arrays.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from .bridge import Singles, get_points
from .names import LIVE_KEY, REST

SAME_MAP = 16 * float(np.finfo(np.float32).eps)  # of the coordinates: an edit this near to one linear map is that map


def after_edit(rest: Singles, shown: Singles, now: Singles) -> Singles:
    """Return the rest shape (N, 3) after an edit of the shape that showed, which has made it what there is now.

    An edit that maps every vertex alike (a transform applied, an origin set) maps the rest shape too. Any other moves
    each vertex of the rest shape as it has moved the vertex that showed.
    """
    if np.array_equal(now, shown):
        return rest
    if np.isfinite(now).all():
        before, after = (points.astype(np.float64) for points in (shown, now))
        middle, middle_after = before.mean(axis=0), after.mean(axis=0)
        linear = np.linalg.lstsq(before - middle, after - middle_after, rcond=None)[0]
        off = np.abs((before - middle) @ linear + middle_after - after).max()
        if off <= SAME_MAP * np.abs(after).max():
            return ((rest - middle) @ linear + middle_after).astype(np.float32)
    return _moved(rest, shown, now)


def _moved(rest: Singles, shown: Singles, now: Singles) -> Singles:
    # what has not moved keeps its very bits, the sign of a zero too
    return np.where(now == shown, rest, rest + (now - shown))


def set_positions(mesh: bpy.types.Mesh, local: Singles) -> None:
    """Write the coordinates (N, 3) of a mesh."""
    mesh.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(local).ravel())
    # this leaves normals and bounding box as they were; one vertex set through RNA has them computed anew
    mesh.vertices[0].co = mesh.vertices[0].co


def carry_rest(mesh: bpy.types.Mesh, rest: Singles) -> None:
    """Let a mesh carry its rest shape (N, 3), unless it does so already."""
    if REST not in mesh.attributes:
        mesh.attributes.new(REST, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest.ravel())


def drop_rest(mesh: bpy.types.Mesh) -> None:
    """Take the rest shape off a mesh, where it carries one: what it shows is its own shape from now on."""
    if REST in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[REST])


def put_back(body: bpy.types.Object, rest: Singles | None, shown: Singles | None = None) -> None:
    """Put the rest shape back, from the attribute on the mesh if it is not given.

    Args:
        shown: (N, 3) what was shown last, which an edit differs from; None: no edit is looked for.
    """
    mesh = body.data
    if mesh.is_editmode:
        _put_back_edited(mesh, shown)
    elif REST in mesh.attributes:
        count = len(mesh.vertices)
        if rest is None or len(rest) != count:
            rest = get_points(mesh.attributes[REST].data, count, "vector")
        if shown is not None and len(shown) == count:
            rest = after_edit(rest, shown, get_points(mesh.attributes["position"].data, count, "vector"))
        rest_mesh(mesh, rest)
    if live := mesh.shape_keys and mesh.shape_keys.key_blocks.get(LIVE_KEY):
        body.shape_key_remove(live)
        if mesh.is_editmode:
            _drop_edited_key(mesh)
    mesh.update_tag()


def rest_mesh(mesh: bpy.types.Mesh, rest: Singles) -> None:
    """Put a mesh that carries its rest shape at rest, and the shape keys that were added to it meanwhile."""
    keys = mesh.shape_keys
    if keys:
        pressed = get_points(keys.reference_key.points, len(rest), "co")
        for key in keys.key_blocks:
            key.points.foreach_set("co", _moved(rest, pressed, get_points(key.points, len(rest), "co")).ravel())
    set_positions(mesh, rest)
    drop_rest(mesh)


def _put_back_edited(mesh: bpy.types.Mesh, shown: Singles | None) -> None:
    """Put the rest shape back into a mesh in Edit Mode, where its vertices live elsewhere."""
    import bmesh

    edited = bmesh.from_edit_mesh(mesh)
    layer = edited.verts.layers.float_vector.get(REST)
    if not layer:
        return
    here = np.array([vertex.co for vertex in edited.verts], np.float32)
    rest = np.array([vertex[layer] for vertex in edited.verts], np.float32)
    shapes = edited.verts.layers.shape.values()
    if shapes:  # the first keys were added while it was pressed
        pressed = np.array([vertex[shapes[0]] for vertex in edited.verts], np.float32)
    else:
        pressed = shown if shown is not None and len(shown) == len(here) else here
    for shape in shapes:
        now = np.array([vertex[shape] for vertex in edited.verts], np.float32)
        for vertex, point in zip(edited.verts, _moved(rest, pressed, now), strict=True):
            vertex[shape] = Vector(point)
    for vertex, point in zip(edited.verts, rest if pressed is here else _moved(rest, pressed, here), strict=True):
        vertex.co = point
    edited.verts.layers.float_vector.remove(layer)
    bmesh.update_edit_mesh(mesh)


def _drop_edited_key(mesh: bpy.types.Mesh) -> None:
    """Take a removed key out of a mesh in Edit Mode too, which would bring it back on leaving."""
    import bmesh

    edited = bmesh.from_edit_mesh(mesh)
    if layer := edited.verts.layers.shape.get(LIVE_KEY):
        edited.verts.layers.shape.remove(layer)
