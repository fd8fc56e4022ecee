"""Write to Blender's objects: kept presses and painted weights.

A press is shown by a modifier (`offset`): nothing here changes a mesh while a body is live.
"""

from __future__ import annotations

from collections.abc import Collection

import bpy
import numpy as np

from ..names import CACHES_OFF, KEPT, KEPT_PRESS, PAINTING
from . import final_mesh, press_modifier, rendered_mesh
from .object_link import ObjectLink, Singles, get_points


def rescue(live: Collection[int]) -> None:
    """Restore objects that show a press but have no session: duplicates, and those left by an undo step or a crash.

    Args:
        live: session_uids of the objects with a running session.
    """
    for body in bpy.data.objects:
        left = press_modifier.modifier_of(body) or CACHES_OFF in body
        if body.session_uid not in live and not body.library and left:
            final_mesh.detach(body)
    press_modifier.sweep_data()


def is_intact(body: bpy.types.Object, link: ObjectLink) -> bool:
    """Return whether an object still has the mesh that was read, and nobody edits its shape."""
    mesh = body.data
    if body.mode not in ("OBJECT", PAINTING) or len(mesh.vertices) != len(link.own):
        return False
    if link.shaped:  # its shape at rest is read at every step
        return True
    return np.array_equal(get_points(mesh.attributes["position"].data, len(link.own), "vector"), link.own)


def keep(context: bpy.types.Context, body: bpy.types.Object, link: ObjectLink, offsets: Singles) -> None:
    """Keep a press, offsets (N, 3) from the shape at rest, in a modifier at the end of the stack."""
    final_mesh.detach(body)
    shown = rendered_mesh.shown(context, body, len(link.rest), link.cuts)
    for each, own in shown:
        press_modifier.set_offsets(each.carrier, offsets if own is None else own.carry(offsets))
    press_modifier.add(body, KEPT, KEPT_PRESS, [each for each, _ in shown])


def paint(body: bpy.types.Object, group: str, weights: Singles) -> None:
    """Set the weight (N,) of every vertex in a vertex group, which is made if missing."""
    painted = body.vertex_groups.get(group) or body.vertex_groups.new(name=group)
    for vertex, weight in enumerate(weights.tolist()):
        painted.add([vertex], weight, "REPLACE")
