"""The modifier that shows a press without changing a mesh: it adds offsets to the shape that it is given.

It is the last of those modifiers that leave the vertices of the mesh as many as they are. The offsets are the vertices
of a mesh of its own, so the artist's mesh, its shape keys, and whatever else uses them know nothing of a press. The
shape that it is given, rig included, is the shape at rest of this frame; an attribute of what is evaluated keeps it.

Part of the bridge: with `bridge`, `bridge_write` and `rest_shape` the only toucher of mesh arrays.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from ..core.base import DimpleError
from .names import PRESS, REST
from .object_link import Singles
from .stack import place_in_stack


def modifier_of(body: bpy.types.Object) -> bpy.types.Modifier | None:
    """Return the modifier that shows a press on an object."""
    ours = (each for each in body.modifiers if each.type == "NODES" and each.node_group)
    return next((each for each in ours if each.node_group.name.startswith(PRESS)), None)


def attach(body: bpy.types.Object) -> bpy.types.Modifier:
    """Give an object the modifier, unless it has it; it shows no press yet."""
    if modifier := modifier_of(body):
        return modifier
    carrier = bpy.data.objects.new(PRESS, bpy.data.meshes.new(PRESS))
    carrier.data.vertices.add(len(body.data.vertices))
    modifier = body.modifiers.new("Dimple Press", "NODES")
    modifier.node_group = _group(carrier)
    modifier.show_in_editmode = False
    body.modifiers.move(len(body.modifiers) - 1, place_in_stack(body))
    return modifier


def detach(body: bpy.types.Object) -> None:
    """Take the modifier off an object, with all that it brought."""
    if modifier := modifier_of(body):
        body.modifiers.remove(modifier)
    sweep_data()


def sweep_data() -> None:
    """Remove what no modifier uses any more; an undo may leave it, and a copy of a body brings it into a scene."""
    for group in [each for each in bpy.data.node_groups if each.name.startswith(PRESS) and not each.users]:
        bpy.data.node_groups.remove(group)
    used = {_carrier_of(each) for each in bpy.data.node_groups}
    for carrier in [each for each in bpy.data.objects if each.name.startswith(PRESS) and not each.library]:
        for collection in carrier.users_collection:
            collection.objects.unlink(carrier)
        if carrier not in used:
            bpy.data.objects.remove(carrier)
    for mesh in [each for each in bpy.data.meshes if each.name.startswith(PRESS) and not each.users]:
        bpy.data.meshes.remove(mesh)


def show(body: bpy.types.Object, offsets: Singles) -> None:
    """Show offsets (N, 3) from the shape at rest, in the object's own space.

    Raises:
        DimpleError: what carries them was deleted.
    """
    carrier = _carrier_of(attach(body).node_group)
    if carrier is None:
        raise DimpleError(f'What shows the press of "{body.name}" was deleted, so its session has ended.')
    mesh = carrier.data
    mesh.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(offsets, np.float32).ravel())
    mesh.update_tag()


def read_rest(body: bpy.types.Object, graph: bpy.types.Depsgraph) -> Singles | None:
    """Return the shape (N, 3) that the modifier is given at this frame, None where nothing is evaluated."""
    count = len(body.data.vertices)
    attribute = body.evaluated_get(graph).data.attributes.get(REST)
    if attribute is None or len(attribute.data) < count:
        return None
    coordinates = np.empty(3 * len(attribute.data), np.float32)
    attribute.data.foreach_get("vector", coordinates)
    return coordinates.reshape(-1, 3)[:count]


def _carrier_of(group: bpy.types.NodeTree) -> bpy.types.Object | None:
    """Return the object whose vertices are the offsets of a press."""
    info = group.nodes.get("Object Info")
    return info.inputs["Object"].default_value if info and info.bl_idname == "GeometryNodeObjectInfo" else None


@contextmanager
def attached(body: bpy.types.Object) -> Iterator[None]:
    """Let an object have the modifier for a while, if it has it not already."""
    had = modifier_of(body) is not None
    try:
        attach(body)
        yield
    finally:
        if not had:
            detach(body)


def _group(carrier: bpy.types.Object) -> bpy.types.NodeTree:
    """Return a node group that keeps the positions it is given, and adds those of the vertices of a carrier."""
    group = bpy.data.node_groups.new(PRESS, "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    new, link = group.nodes.new, group.links.new
    given, result = new("NodeGroupInput"), new("NodeGroupOutput")
    kinds = "InputPosition", "InputIndex", "ObjectInfo", "StoreNamedAttribute", "SampleIndex", "SetPosition"
    position, index, info, keep, sample, move = (new(f"GeometryNode{kind}") for kind in kinds)
    keep.data_type = sample.data_type = "FLOAT_VECTOR"
    keep.inputs["Name"].default_value = REST
    info.name, info.inputs["Object"].default_value = "Object Info", carrier
    link(given.outputs[0], keep.inputs["Geometry"])
    link(position.outputs[0], keep.inputs["Value"])
    link(info.outputs["Geometry"], sample.inputs["Geometry"])
    link(position.outputs[0], sample.inputs["Value"])
    link(index.outputs[0], sample.inputs["Index"])
    link(keep.outputs[0], move.inputs["Geometry"])
    link(sample.outputs[0], move.inputs["Offset"])
    link(move.outputs[0], result.inputs[0])
    return group
