"""Play a vertex animation texture of Dimple in Blender: a sample of how a shader reads one.

In Blender's text editor: `play(Path("/the/folder/Ball_vat"))`. The mesh moves by geometry nodes, and its material
displaces the same way (Vector Displacement), for a renderer that has no nodes for geometry. A game engine does the same
in its vertex shader: look up the texel at the second UV map, `rows / height` lower each frame, and add it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy


def play(folder: Path, *, first: int = 1) -> Any:
    """Load the mesh and the picture of a folder and let them play from a frame on; return the object."""
    layout = json.loads((folder / "layout.json").read_text(encoding="utf-8"))
    before = set(bpy.context.scene.objects)
    bpy.ops.import_scene.gltf(filepath=str(folder / "mesh.glb"), merge_vertices=False)
    (obj,) = (each for each in set(bpy.context.scene.objects) - before if each.type == "MESH")
    image = bpy.data.images.load(str(folder / "offsets.exr"))
    image.colorspace_settings.name = "Non-Color"
    group = bpy.data.node_groups.new("Vertex Texture", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    uv_map = obj.data.uv_layers[1].name
    nodes, links = group.nodes, group.links
    uv = nodes.new("GeometryNodeInputNamedAttribute")
    uv.data_type, uv.inputs["Name"].default_value = "FLOAT_VECTOR", uv_map
    texel = nodes.new("GeometryNodeImageTexture")
    texel.interpolation, texel.inputs["Image"].default_value = "Closest", image
    links.new(_moved(group, uv.outputs["Attribute"], layout, first), texel.inputs["Vector"])
    move = nodes.new("GeometryNodeSetPosition")
    links.new(_offset(group, texel.outputs["Color"]), move.inputs["Offset"])
    links.new(nodes.new("NodeGroupInput").outputs["Geometry"], move.inputs["Geometry"])
    links.new(move.outputs["Geometry"], nodes.new("NodeGroupOutput").inputs["Geometry"])
    obj.modifiers.new("Vertex Texture", "NODES").node_group = group
    return obj


def displace(obj: Any, folder: Path, *, first: int = 1) -> Any:
    """Return a material that displaces an object by the texture, in place of geometry nodes."""
    layout = json.loads((folder / "layout.json").read_text(encoding="utf-8"))
    material = bpy.data.materials.new("Vertex Texture")
    material.use_nodes, material.displacement_method = True, "DISPLACEMENT"
    tree = material.node_tree
    uv = tree.nodes.new("ShaderNodeUVMap")
    uv.uv_map = obj.data.uv_layers[1].name
    texel = tree.nodes.new("ShaderNodeTexImage")
    texel.image, texel.interpolation = bpy.data.images.load(str(folder / "offsets.exr")), "Closest"
    texel.image.colorspace_settings.name = "Non-Color"
    tree.links.new(_moved(tree, uv.outputs["UV"], layout, first), texel.inputs["Vector"])
    move = tree.nodes.new("ShaderNodeVectorDisplacement")
    move.space = "OBJECT"
    move.inputs["Midlevel"].default_value, move.inputs["Scale"].default_value = 0.0, 1.0  # it is 0.01 in some versions
    tree.links.new(_offset(tree, texel.outputs["Color"]), move.inputs["Vector"])
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(move.outputs["Displacement"], output.inputs["Displacement"])
    obj.data.materials.clear()
    obj.data.materials.append(material)
    return material


def _moved(tree: Any, uv: Any, layout: dict[str, Any], first: int) -> Any:
    """Return where to look: the place of a vertex, lower by the rows of each frame."""
    add = tree.nodes.new("ShaderNodeVectorMath")
    add.operation = "ADD"
    tree.links.new(uv, add.inputs[0])
    driver = add.inputs[1].driver_add("default_value", 1).driver
    at = f"min(max(frame - {first}, 0), {layout['frames'] - 1})"
    driver.expression = f"-{layout['rows'] / layout['height']!r} * {at}"
    return add.outputs[0]


def _offset(tree: Any, color: Any) -> Any:
    """Return an offset of Blender's, Z up, from a colour, Y up."""
    split, join = tree.nodes.new("ShaderNodeSeparateXYZ"), tree.nodes.new("ShaderNodeCombineXYZ")
    tree.links.new(color, split.inputs[0])
    turn = tree.nodes.new("ShaderNodeMath")
    turn.operation, turn.inputs[1].default_value = "MULTIPLY", -1.0
    tree.links.new(split.outputs["Z"], turn.inputs[0])
    for source, axis in ((split.outputs["X"], "X"), (turn.outputs[0], "Y"), (split.outputs["Y"], "Z")):
        tree.links.new(source, join.inputs[axis])
    return join.outputs[0]
