"""The modifier, last in the stack, that shows a running press, a kept press or a bake without changing a mesh.

It takes the final mesh, subdivides it if it is too coarse for the fingertip, and adds an offset to each vertex. The
offsets are the vertices of a separate mesh, the carrier, so a press does not affect the artist's mesh, its shape keys
or their other users. Viewport and render may have different numbers of vertices: each has its own carrier, and a mesh
with any other number of vertices stays unchanged.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import bpy

from ..names import CARRIER, OURS, PRESS, REST
from .modifier_kinds import shows


class Shown(NamedTuple):
    """How a mesh with a certain number of vertices is shown."""

    given: int  # number of vertices that the modifier receives
    cuts: int  # number of subdivisions, each of which halves all edges
    carrier: bpy.types.Object  # the object whose vertices are the offsets


def modifier_of(body: bpy.types.Object) -> bpy.types.Modifier | None:
    """Return the modifier that shows a running press on an object."""
    return next((each for each in body.modifiers if shows(each, PRESS)), None)


def new_carrier(count: int = 0) -> bpy.types.Object:
    """Return a new carrier with a number of zero offsets."""
    carrier = bpy.data.objects.new(CARRIER, bpy.data.meshes.new(CARRIER))
    carrier.hide_render = carrier.hide_viewport = True
    carrier.data.vertices.add(count)
    return carrier


def add(body: bpy.types.Object, name: str, kind: str, shown: Sequence[Shown]) -> bpy.types.Modifier:
    """Give an object a modifier at the end of its stack."""
    modifier = body.modifiers.new(name, "NODES")
    modifier.node_group = _group(kind, shown)
    modifier.show_in_editmode = False
    modifier.use_pin_to_last = True
    body.modifiers.move(list(body.modifiers).index(modifier), len(body.modifiers) - 1)
    return modifier


def remove(body: bpy.types.Object, kind: str) -> int:
    """Remove our modifiers of a kind from an object, with their data; return their number."""
    ours = [each for each in body.modifiers if shows(each, kind)]
    for modifier in ours:
        body.modifiers.remove(modifier)
    sweep_data()
    return len(ours)


def sweep_data() -> None:
    """Remove our data that no modifier uses, as an undo may leave it; unlink carriers that a paste put in the scene."""
    carriers = [each for each in bpy.data.objects if each.name.startswith(CARRIER) and not each.library]
    for carrier in carriers:
        for collection in carrier.users_collection:
            collection.objects.unlink(carrier)
    for group in [each for each in bpy.data.node_groups if each.name.startswith(OURS) and not each.users]:
        bpy.data.node_groups.remove(group)
    for carrier in [each for each in carriers if not each.users]:
        bpy.data.objects.remove(carrier)
    for mesh in [each for each in bpy.data.meshes if each.name.startswith(CARRIER) and not each.users]:
        bpy.data.meshes.remove(mesh)


def show(body: bpy.types.Object, offsets: Any) -> None:
    """Show offsets (N, 3) of a running press from the shape at rest, in the object's own space."""
    modifier = modifier_of(body)
    if modifier is None:  # its session is about to end, or to attach the modifier again
        return
    info = next(each for each in modifier.node_group.nodes if each.type == "OBJECT_INFO")
    if info.inputs["Object"].default_value is None:  # the user deleted it
        info.inputs["Object"].default_value = new_carrier()
    set_offsets(info.inputs["Object"].default_value, offsets)


def set_offsets(carrier: bpy.types.Object, offsets: Any) -> None:
    """Store offsets (N, 3) in a carrier."""
    mesh = carrier.data
    if len(mesh.vertices) != len(offsets):
        mesh.clear_geometry()
        mesh.vertices.add(len(offsets))
    mesh.attributes["position"].data.foreach_set("vector", offsets.ravel())
    mesh.update_tag()


def carriers(modifier: bpy.types.Modifier) -> Iterator[bpy.types.Object]:
    """Yield the carriers of one of our modifiers, the viewport's first."""
    infos = [each for each in modifier.node_group.nodes if each.type == "OBJECT_INFO"]
    for info in sorted(infos, key=lambda each: each.name):
        if carrier := info.inputs["Object"].default_value:
            yield carrier


def files(modifier: bpy.types.Modifier) -> list[tuple[Path, float]]:
    """Return the PC2 files that one of our modifiers plays, the viewport's first, each with its first frame."""
    plays, library = [each.modifiers[0] for each in carriers(modifier) if each.modifiers], modifier.id_data.library
    return [(Path(bpy.path.abspath(each.filepath, library=library)), each.frame_start) for each in plays]


def _group(kind: str, shown: Sequence[Shown]) -> bpy.types.NodeTree:
    """Return a node group that adds to a mesh the offsets of the carrier for its number of vertices, if any."""
    group = bpy.data.node_groups.new(kind, "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    new, link = group.nodes.new, group.links.new
    given, size = new("NodeGroupInput"), new("GeometryNodeAttributeDomainSize")
    link(given.outputs[0], size.inputs[0])
    result = given.outputs[0]
    for each in shown:
        is_it, choose = new("FunctionNodeCompare"), new("GeometryNodeSwitch")
        is_it.data_type, is_it.operation, choose.input_type = "INT", "EQUAL", "GEOMETRY"
        whole, other = (socket for socket in is_it.inputs if socket.type == "INT")
        other.default_value = each.given
        link(size.outputs[0], whole)
        link(is_it.outputs[0], choose.inputs["Switch"])
        link(result, choose.inputs["False"])
        finer = _finer(group, given.outputs[0], each.cuts) if each.cuts else given.outputs[0]
        link(_moved(group, finer, each.carrier, keep=kind == PRESS), choose.inputs["True"])
        result = choose.outputs[0]
    link(result, new("NodeGroupOutput").inputs[0])
    return group


def _finer(group: bpy.types.NodeTree, given: bpy.types.NodeSocket, cuts: int) -> bpy.types.NodeSocket:
    """Subdivide a mesh without changing its shape and shading; the normals follow when it is moved afterwards."""
    new, link = group.nodes.new, group.links.new
    normal, capture, cut = new("GeometryNodeInputNormal"), new("GeometryNodeCaptureAttribute"), None
    capture.domain = "CORNER"
    capture.capture_items.new("VECTOR", "Normal")
    cut, smooth, shade = (new(f"GeometryNode{name}") for name in ("SubdivideMesh", "SetShadeSmooth", "SetMeshNormal"))
    cut.inputs["Level"].default_value = cuts
    shade.mode, shade.domain = "TANGENT_SPACE", "CORNER"
    link(given, capture.inputs[0])
    link(normal.outputs["Normal"], capture.inputs["Normal"])
    link(capture.outputs[0], cut.inputs["Mesh"])
    link(cut.outputs[0], smooth.inputs["Geometry"])
    link(smooth.outputs[0], shade.inputs["Mesh"])
    link(capture.outputs["Normal"], next(each for each in shade.inputs if each.type == "VECTOR"))
    return shade.outputs[0]


def _moved(
    group: bpy.types.NodeTree, given: bpy.types.NodeSocket, carrier: bpy.types.Object, *, keep: bool
) -> bpy.types.NodeSocket:
    """Add the offsets of a carrier to a mesh; with `keep`, the positions before are stored in the attribute REST."""
    new, link = group.nodes.new, group.links.new
    kinds = "InputPosition", "InputIndex", "ObjectInfo", "SampleIndex", "SetPosition"
    position, index, info, sample, move = (new(f"GeometryNode{kind}") for kind in kinds)
    sample.data_type = "FLOAT_VECTOR"
    info.inputs["Object"].default_value = carrier
    if keep:
        store = new("GeometryNodeStoreNamedAttribute")
        store.data_type, store.inputs["Name"].default_value = "FLOAT_VECTOR", REST
        link(given, store.inputs["Geometry"])
        link(position.outputs[0], store.inputs["Value"])
        given = store.outputs[0]
    link(info.outputs["Geometry"], sample.inputs["Geometry"])
    link(position.outputs[0], sample.inputs["Value"])
    link(index.outputs[0], sample.inputs["Index"])
    link(given, move.inputs["Geometry"])
    link(sample.outputs[0], move.inputs["Offset"])
    return move.outputs[0]
