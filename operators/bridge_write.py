"""The bridge's way back: show a running session on a mesh, and put the rest shape back bit for bit.

While a session shows, the mesh carries its rest shape in an attribute. So an undo step, an autosave or a crash
that catches it pressed loses nothing: `rescue` finds such meshes and puts them right. With shape keys the mesh
itself is left alone, and one more key shows the session.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import bpy
import numpy as np

from ..core.base import DimpleError
from .bridge import Link, Singles, get_points
from .names import CACHE, KEPT_KEY, LIVE_KEY, REST


@dataclass(frozen=True, slots=True, kw_only=True)
class Borrowed:
    """Hold what of an object was changed to show a session on it.

    shared: session_uid of the mesh it had together with other objects, None if it has its own.
    copy: session_uid of the mesh that shows the session.  caches: names of the bakes that were switched off.
    """

    shared: int | None
    copy: int
    caches: tuple[str, ...]


def borrow(body: bpy.types.Object, link: Link, *, others: Collection[int] = ()) -> Borrowed:
    """Make an object ready to show a session, and return what was changed.

    Args:
        others: meshes that other sessions will give back to their objects.
    """
    mesh, shared = body.data, None
    if is_shared(mesh) or mesh.session_uid in others:
        shared, body.data = mesh.session_uid, mesh.copy()
        _remember("Press a copy of a shared mesh")
    if not body.data.shape_keys:
        _carry_rest(body.data, link.rest)
    caches = tuple(modifier.name for modifier in body.modifiers if is_cache(modifier) and modifier.show_viewport)
    _switch(body, caches, False)
    return Borrowed(shared=shared, copy=body.data.session_uid, caches=caches)


def is_shared(mesh: bpy.types.Mesh) -> bool:
    """Tell whether several objects use a mesh."""
    return mesh.users - mesh.use_fake_user > 1


def is_cache(modifier: bpy.types.Modifier) -> bool:
    """Tell whether a modifier plays a bake of ours."""
    return modifier.type == "MESH_CACHE" and modifier.name.startswith(CACHE)


def is_showable(body: bpy.types.Object, link: Link) -> bool:
    """Tell whether an object still has the mesh that was read, and nobody edits it."""
    return body.mode == "OBJECT" and len(body.data.vertices) == len(link.rest)


def show(body: bpy.types.Object, link: Link, local: Singles) -> None:
    """Show coordinates (N, 3) on an object.

    Raises:
        DimpleError: the mesh is being edited or is no longer the one that was read.
    """
    if not is_showable(body, link):
        raise DimpleError(f'"{body.name}" was edited while it was pressed, so its session has ended.')
    mesh = body.data
    if mesh.shape_keys:
        _show_key(body, link, local)
    else:
        _carry_rest(mesh, link.rest)
        _set_positions(mesh, local)
    mesh.update_tag()


def pause(body: bpy.types.Object, link: Link, borrowed: Borrowed, *, for_file: bool = False) -> None:
    """Put everything back for a moment; for a file the shared mesh too.

    Not for an undo step: that must know which mesh the object has, or it gives it one that is gone.
    """
    _put_back(body, link.rest)
    _switch(body, borrowed.caches, True)
    if for_file:
        _exchange(body, borrowed.shared)


def resume(body: bpy.types.Object, borrowed: Borrowed) -> None:
    """Take again what was put back for a moment."""
    if borrowed.shared is not None:
        _exchange(body, borrowed.copy)
    _switch(body, borrowed.caches, False)


def give_back(body: bpy.types.Object, link: Link, borrowed: Borrowed, *, mesh: bool = True) -> None:
    """Put the rest shape and everything borrowed back.

    Args:
        mesh: also the shared mesh. Not while Blender undoes: it has just said which mesh there is.
    """
    pause(body, link, borrowed)
    copy = body.data
    if mesh and _exchange(body, borrowed.shared):
        if not copy.users:
            bpy.data.meshes.remove(copy)
        _remember("Give the shared mesh back")


def keep(body: bpy.types.Object) -> None:
    """Make the shape that shows now the object's own; with shape keys it becomes a key that can be blended."""
    if body.data.shape_keys:
        if live := body.data.shape_keys.key_blocks.get(LIVE_KEY):
            live.name = KEPT_KEY
    else:
        _drop_rest(body.data)


def rescue(live: Collection[int]) -> None:
    """Put meshes right that were caught pressed by an undo step, an autosave or a crash.

    Args:
        live: session_uids of the objects whose sessions go on.
    """
    bodies = [body for body in bpy.data.objects if body.type == "MESH" and not body.data.library]
    in_use = {body.data.session_uid for body in bodies if body.session_uid in live}
    for body in bodies:
        if body.data.session_uid not in in_use and _is_pressed(body.data):
            _put_back(body, None)


def _switch(body: bpy.types.Object, caches: Collection[str], shown: bool) -> None:
    for name in caches:
        if name in body.modifiers:
            body.modifiers[name].show_viewport = shown


def _exchange(body: bpy.types.Object, uid: int | None) -> bool:
    """Give an object the mesh with a session_uid; return whether it had another."""
    wanted = next((mesh for mesh in bpy.data.meshes if mesh.session_uid == uid), None)
    if wanted is None or wanted == body.data or body.mode != "OBJECT":
        return False
    body.data = wanted
    return True


def _remember(what: str) -> None:
    """Push an undo step: Blender must know which mesh an object has, or an undo gives it one that is gone."""
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=what)


def add_key(body: bpy.types.Object, name: str, link: Link, local: Singles) -> bpy.types.ShapeKey:
    """Add a shape key that shows coordinates (N, 3) when its value is 1; the first one needs a basis."""
    active = body.active_shape_key_index
    if not body.data.shape_keys:
        body.shape_key_add(name="Basis", from_mix=False)
    key = body.shape_key_add(name=name, from_mix=False)
    key.value, key.relative_key = 0.0, body.data.shape_keys.reference_key
    body.active_shape_key_index = active
    set_key(body, key, link, local)
    return key


def set_key(body: bpy.types.Object, key: bpy.types.ShapeKey, link: Link, local: Singles) -> None:
    """Let a shape key show coordinates (N, 3), whatever the other keys add."""
    basis = get_points(body.data.shape_keys.reference_key.points, len(link.rest), "co")
    key.points.foreach_set("co", (basis + (local - link.rest)).ravel())


def _show_key(body: bpy.types.Object, link: Link, local: Singles) -> None:
    live = body.data.shape_keys.key_blocks.get(LIVE_KEY)
    if live:
        set_key(body, live, link, local)
    else:
        live = add_key(body, LIVE_KEY, link, local)
    live.value = 1.0


def _set_positions(mesh: bpy.types.Mesh, local: Singles) -> None:
    mesh.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(local).ravel())
    # the fast way leaves normals and bounding box as they were; one vertex by the slow way mends that
    mesh.vertices[0].co = mesh.vertices[0].co


def _carry_rest(mesh: bpy.types.Mesh, rest: Singles) -> None:
    if REST not in mesh.attributes:
        mesh.attributes.new(REST, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest.ravel())


def _drop_rest(mesh: bpy.types.Mesh) -> None:
    if REST in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[REST])


def _is_pressed(mesh: bpy.types.Mesh) -> bool:
    keys = mesh.shape_keys
    return REST in mesh.attributes or bool(keys and LIVE_KEY in keys.key_blocks)


def _put_back(body: bpy.types.Object, rest: Singles | None) -> None:
    """Put the rest shape back, from the attribute on the mesh if it is not given."""
    mesh = body.data
    if mesh.shape_keys:
        if live := mesh.shape_keys.key_blocks.get(LIVE_KEY):
            body.shape_key_remove(live)
            if mesh.is_editmode:
                _drop_edited_key(mesh)
    elif mesh.is_editmode:
        _put_back_edited(mesh)
    elif REST in mesh.attributes:
        carried = get_points(mesh.attributes[REST].data, len(mesh.vertices), "vector")
        _set_positions(mesh, rest if rest is not None and len(rest) == len(carried) else carried)
        _drop_rest(mesh)
    mesh.update_tag()


def _put_back_edited(mesh: bpy.types.Mesh) -> None:
    """Put the rest shape back into a mesh in Edit Mode, where its vertices live elsewhere."""
    import bmesh

    edited = bmesh.from_edit_mesh(mesh)
    layer = edited.verts.layers.float_vector.get(REST)
    if layer:
        for vertex in edited.verts:
            vertex.co = vertex[layer]
        edited.verts.layers.float_vector.remove(layer)
        bmesh.update_edit_mesh(mesh)


def _drop_edited_key(mesh: bpy.types.Mesh) -> None:
    """Take a removed key out of a mesh in Edit Mode too, which would bring it back on leaving."""
    import bmesh

    edited = bmesh.from_edit_mesh(mesh)
    if layer := edited.verts.layers.shape.get(LIVE_KEY):
        edited.verts.layers.shape.remove(layer)
