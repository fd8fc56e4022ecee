"""Write through the bridge: show a running session on a mesh, and put the rest shape back bit for bit.

While a session shows, the mesh carries its rest shape in an attribute. So an undo step, an autosave or a crash
that catches it pressed loses nothing: `rescue` finds such meshes and puts them right. With shape keys the mesh
itself is left alone, and one more key shows the session.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import bpy
import numpy as np

from .bridge import ObjectLink, Singles, get_points
from .names import CACHE, CACHES_OFF, KEPT_KEY, LIVE_KEY, PAINTING, REST
from .rest_shape import carry_rest, drop_rest, put_back, rest_mesh, set_positions


@dataclass(frozen=True, slots=True, kw_only=True)
class Borrowed:
    """What of an object was changed to show a session on it.

    shared: session_uid of the mesh it had together with other objects, None if it has its own.
    copy: session_uid of the mesh that shows the session.
    """

    shared: int | None
    copy: int


def borrow(body: bpy.types.Object, link: ObjectLink, *, others: Collection[int] = ()) -> Borrowed:
    """Make an object ready to show a session, and return what was changed.

    Args:
        others: meshes that other sessions will give back to their objects.
    """
    mesh, shared = body.data, None
    if is_shared(mesh) or mesh.session_uid in others:
        shared, body.data = mesh.session_uid, mesh.copy()
        remember("Press a copy of a shared mesh")
    if not body.data.shape_keys:
        carry_rest(body.data, link.rest)
    _switch_caches_off(body)
    return Borrowed(shared=shared, copy=body.data.session_uid)


def is_shared(mesh: bpy.types.Mesh) -> bool:
    """Tell whether several objects use a mesh."""
    return mesh.users - mesh.use_fake_user > 1


def is_cache(modifier: bpy.types.Modifier) -> bool:
    """Tell whether a modifier plays a bake of ours."""
    return modifier.type == "MESH_CACHE" and modifier.name.startswith(CACHE)


def is_showable(body: bpy.types.Object, link: ObjectLink, borrowed: Borrowed) -> bool:
    """Tell whether an object still has the mesh that was read, and nobody edits its shape."""
    mesh = body.data
    # weights that are painted on a copy of a shared mesh would be lost with it
    unshaped = body.mode == "OBJECT" or (body.mode == PAINTING and borrowed.shared is None)
    return unshaped and mesh.session_uid == borrowed.copy and len(mesh.vertices) == len(link.rest)


def is_intact(body: bpy.types.Object, link: ObjectLink, borrowed: Borrowed, shown: Singles | None) -> bool:
    """Tell whether an object is as its session left it.

    Args:
        shown: (N, 3) what `show` wrote last, None where nothing has been shown yet.
    """
    if not is_showable(body, link, borrowed):
        return False
    return shown is None or np.array_equal(_showing(body.data), shown)


def show(body: bpy.types.Object, link: ObjectLink, local: Singles) -> Singles:
    """Show coordinates (N, 3) on an object.

    Returns:
        (N, 3) what was written: the coordinates themselves, or those of the shape key that shows them.
    """
    mesh = body.data
    if mesh.shape_keys:
        if REST in mesh.attributes:  # the first keys were added while it was pressed
            rest_mesh(mesh, link.rest)
        local = _show_key(body, link, local)
    else:
        carry_rest(mesh, link.rest)
        set_positions(mesh, local)
    mesh.update_tag()
    return local


def pause(body: bpy.types.Object, link: ObjectLink, borrowed: Borrowed, *, for_file: bool = False) -> None:
    """Put everything back for a moment; for a file the shared mesh too.

    Not for an undo step: that must know which mesh the object has, or it gives it one that is gone.
    """
    put_back(body, link.rest)
    _switch_caches_on(body)
    if for_file:
        _exchange(body, borrowed.shared)


def resume(body: bpy.types.Object, borrowed: Borrowed) -> None:
    """Take again what was put back for a moment."""
    if borrowed.shared is not None:
        _exchange(body, borrowed.copy)
    _switch_caches_off(body)


def give_back(
    body: bpy.types.Object, link: ObjectLink, borrowed: Borrowed, shown: Singles | None, *, undoing: bool = False
) -> None:
    """Put the rest shape and everything borrowed back; what the artist has changed since stays changed.

    Args:
        shown: (N, 3) what `show` wrote last.
        undoing: Blender undoes. It has just set every mesh: what it set is no edit, and no mesh is exchanged.
    """
    if undoing:
        put_back(body, None)
    elif body.data.session_uid == borrowed.copy:
        put_back(body, link.rest, shown)
    elif (lost := _mesh(borrowed.copy)) and REST in lost.attributes and not lost.is_editmode:
        rest_mesh(lost, link.rest)  # the object was given another mesh
    _switch_caches_on(body)
    copy = body.data
    if not undoing and copy.session_uid == borrowed.copy and _exchange(body, borrowed.shared):
        if not copy.users:
            bpy.data.meshes.remove(copy)
        remember("Give the shared mesh back")


def keep(body: bpy.types.Object) -> None:
    """Make the shape that shows now the object's own; with shape keys it becomes a key that can be blended."""
    if body.data.shape_keys:
        if live := body.data.shape_keys.key_blocks.get(LIVE_KEY):
            live.name = KEPT_KEY
    drop_rest(body.data)


def rescue(live: Collection[int]) -> None:
    """Put objects right that show a session they do not have: duplicates, or caught by an undo step or a crash.

    Args:
        live: session_uids of the objects whose sessions go on.
    """
    bodies = [body for body in bpy.data.objects if body.type == "MESH" and not body.data.library]
    in_use = {body.data.session_uid for body in bodies if body.session_uid in live}
    for body in bodies:
        if body.session_uid in live:
            continue
        if body.data.session_uid not in in_use and _is_pressed(body.data):
            put_back(body, None)
        if CACHES_OFF in body:
            _switch_caches_on(body)


def _switch_caches_off(body: bpy.types.Object) -> None:
    """Switch off the bakes that show; the object remembers which, and so do its duplicates."""
    shown = [modifier for modifier in body.modifiers if is_cache(modifier) and modifier.show_viewport]
    for modifier in shown:
        modifier.show_viewport = False
    if shown:
        body[CACHES_OFF] = "\n".join(modifier.name for modifier in shown)


def _switch_caches_on(body: bpy.types.Object) -> None:
    for name in str(body.pop(CACHES_OFF, "")).split("\n"):
        if name in body.modifiers:
            body.modifiers[name].show_viewport = True


def _mesh(uid: int | None) -> bpy.types.Mesh | None:
    return next((mesh for mesh in bpy.data.meshes if mesh.session_uid == uid), None)


def _exchange(body: bpy.types.Object, uid: int | None) -> bool:
    """Give an object the mesh with a session_uid; return whether it had another."""
    wanted = _mesh(uid)
    if wanted is None or wanted == body.data or body.mode != "OBJECT":
        return False
    body.data = wanted
    return True


def remember(what: str) -> None:
    """Push an undo step, where there are any.

    For one, Blender must know which mesh an object has, or an undo gives it one that is gone.
    """
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=what)


def add_key(body: bpy.types.Object, name: str, link: ObjectLink, local: Singles) -> bpy.types.ShapeKey:
    """Add a shape key that shows coordinates (N, 3) when its value is 1; the first one needs a basis."""
    active = body.active_shape_key_index
    if not body.data.shape_keys:
        body.shape_key_add(name="Basis", from_mix=False)
    key = body.shape_key_add(name=name, from_mix=False)
    key.value, key.relative_key = 0.0, body.data.shape_keys.reference_key
    body.active_shape_key_index = active
    set_key(body, key, link, local)
    return key


def set_key(body: bpy.types.Object, key: bpy.types.ShapeKey, link: ObjectLink, local: Singles) -> Singles:
    """Let a shape key show coordinates (N, 3), whatever the other keys add; return its own."""
    points = get_points(body.data.shape_keys.reference_key.points, len(link.rest), "co") + (local - link.rest)
    key.points.foreach_set("co", points.ravel())
    return points


def _show_key(body: bpy.types.Object, link: ObjectLink, local: Singles) -> Singles:
    live = body.data.shape_keys.key_blocks.get(LIVE_KEY) or add_key(body, LIVE_KEY, link, local)
    live.value = 1.0
    return set_key(body, live, link, local)


def _showing(mesh: bpy.types.Mesh) -> Singles | None:
    """Return the coordinates (N, 3) that show a session, None where nothing shows one."""
    count, keys = len(mesh.vertices), mesh.shape_keys
    if REST in mesh.attributes:
        return get_points(mesh.attributes["position"].data, count, "vector")
    live = keys.key_blocks.get(LIVE_KEY) if keys else None
    return get_points(live.points, count, "co") if live else None


def _is_pressed(mesh: bpy.types.Mesh) -> bool:
    keys = mesh.shape_keys
    return REST in mesh.attributes or bool(keys and LIVE_KEY in keys.key_blocks)


def paint(body: bpy.types.Object, group: str, weights: Singles, attribute: str, values: Singles) -> None:
    """Give every vertex a weight (N,) in a vertex group, and a value (N,) of a float attribute."""
    painted = body.vertex_groups.get(group) or body.vertex_groups.new(name=group)
    for vertex, weight in enumerate(weights.tolist()):
        painted.add([vertex], weight, "REPLACE")
    layer = body.data.attributes.get(attribute) or body.data.attributes.new(attribute, "FLOAT", "POINT")
    layer.data.foreach_set("value", values.astype(np.float32))
