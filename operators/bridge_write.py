"""Write through the bridge: show a running session, keep a press for good, shape keys and painted weights.

A press is shown by a modifier (`offset`): nothing here but `keep` changes a mesh while a body is live.
"""

from __future__ import annotations

from collections.abc import Collection

import bpy
import numpy as np

from . import offset
from .bridge import ObjectLink, Singles, get_points
from .names import CACHES_OFF, KEPT, PAINTING
from .stack import is_cache, shaping


def borrow(body: bpy.types.Object) -> None:
    """Make an object ready to show a session: its bakes are switched off."""
    try:
        offset.attach(body)
    except BaseException:
        offset.detach(body)
        raise
    shown = [modifier for modifier in body.modifiers if is_cache(modifier) and modifier.show_viewport]
    for modifier in shown:
        modifier.show_viewport = False
    if shown:
        body[CACHES_OFF] = "\n".join(modifier.name for modifier in shown)  # its duplicates know it too


def give_back(body: bpy.types.Object) -> None:
    """Take away what shows a session, and switch the bakes on again."""
    offset.detach(body)
    for name in str(body.pop(CACHES_OFF, "")).split("\n"):
        if name in body.modifiers:
            body.modifiers[name].show_viewport = True


def rescue(live: Collection[int]) -> None:
    """Put objects right that show a session they do not have: duplicates, or caught by an undo step or a crash.

    Args:
        live: session_uids of the objects whose sessions go on.
    """
    for body in bpy.data.objects:
        if body.session_uid not in live and not body.library and (offset.modifier_of(body) or CACHES_OFF in body):
            give_back(body)
    offset.sweep_data()


def is_shared(mesh: bpy.types.Mesh) -> bool:
    """Tell whether several objects use a mesh."""
    return mesh.users - mesh.use_fake_user > 1


def is_intact(body: bpy.types.Object, link: ObjectLink) -> bool:
    """Tell whether an object still has the mesh that was read, and nobody edits its shape."""
    mesh = body.data
    if body.mode not in ("OBJECT", PAINTING) or len(mesh.vertices) != len(link.rest):
        return False
    if link.shaped:  # its shape at rest is read anew at every step
        return True
    return np.array_equal(get_points(mesh.attributes["position"].data, len(link.rest), "vector"), link.rest)


def keep(body: bpy.types.Object, local: Singles, rest: Singles) -> None:
    """Make the shape that shows now, coordinates (N, 3), the object's own.

    With shape keys it becomes a key that can be blended; where modifiers shape the mesh before the press, keys are
    absolute, or the mesh is of another file, the modifier stays.

    Args:
        rest: (N, 3) the shape at rest of this frame.
    """
    modifier = offset.modifier_of(body)
    keys = body.data.shape_keys
    if modifier and (shaping(body) or body.data.library or (keys and not keys.use_relative)):
        modifier.name = KEPT
        modifier.node_group.name = KEPT
        return
    if is_shared(body.data):
        body.data = body.data.copy()
    if body.data.shape_keys:
        add_key(body, KEPT, local - rest).value = 1.0
    else:
        set_positions(body.data, local)


def set_positions(mesh: bpy.types.Mesh, local: Singles) -> None:
    """Write the coordinates (N, 3) of a mesh."""
    mesh.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(local).ravel())
    # this leaves normals and bounding box as they were; one vertex set through RNA has them computed anew
    mesh.vertices[0].co = mesh.vertices[0].co
    mesh.update_tag()


def remember(what: str) -> None:
    """Push an undo step, where there are any."""
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=what)


def add_key(body: bpy.types.Object, name: str, offsets: Singles) -> bpy.types.ShapeKey:
    """Add a shape key that moves the vertices by offsets (N, 3) when its value is 1; the first one needs a basis."""
    active = body.active_shape_key_index
    if not body.data.shape_keys:
        body.shape_key_add(name="Basis", from_mix=False)
    key = body.shape_key_add(name=name, from_mix=False)
    reference = body.data.shape_keys.reference_key
    key.value, key.relative_key = 0.0, reference
    body.active_shape_key_index = active
    key.points.foreach_set("co", (get_points(reference.points, len(offsets), "co") + offsets).ravel())
    return key


def paint(body: bpy.types.Object, group: str, weights: Singles, attribute: str, values: Singles) -> None:
    """Give every vertex a weight (N,) in a vertex group, and a value (N,) of a float attribute."""
    painted = body.vertex_groups.get(group) or body.vertex_groups.new(name=group)
    for vertex, weight in enumerate(weights.tolist()):
        painted.add([vertex], weight, "REPLACE")
    layer = body.data.attributes.get(attribute) or body.data.attributes.new(attribute, "FLOAT", "POINT")
    layer.data.foreach_set("value", values.astype(np.float32))
