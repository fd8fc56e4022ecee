"""The surface of a body whose own mesh is too coarse to show its dent, drawn over that mesh where it can be seen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

if TYPE_CHECKING:
    import numpy as np

LEAST = 1e-3  # of the size: what differs less from the mesh is no dent
NEARER = 1e-4  # in front of the mesh, in the depth of the picture
SHADE = 0.7  # of the colour, where the surface faces the viewer: about Blender's own light in solid view

GREY = (0.8, 0.8, 0.8)  # of an object without a material

_VERTEX = """
void main() {
    vec4 there = matrix * vec4(place, 1.0), over = matrix * vec4(mesh_place, 1.0);
    there.z = (over.z / over.w - nearer) * there.w;  // as near as the mesh: what hides that hides the dent
    facing = dot(normal, towards);
    gl_Position = there;
}
"""
_FRAGMENT = """
void main() { shown = vec4(colour * (0.3 + 0.7 * max(facing, 0.0)), 1.0); }
"""
_shaders: list[Any] = []


class Dent(NamedTuple):
    """A refined surface that differs from the mesh.

    places, mesh_places: (n, 3) where it is, and where the mesh shows it, in the scene.
    normals: (n, 3) unit vectors.
    All row by row, single: Blender's buffers take any other layout for that one.
    """

    places: np.ndarray
    mesh_places: np.ndarray
    normals: np.ndarray


def dent_of(entry: Any) -> Dent | None:
    """Return the surface of a session where it has a dent that its object cannot show, else None."""
    import numpy as np

    refined = entry.link.refined
    if refined is None:
        return None
    x = entry.session.positions().astype(np.float64)
    carried = refined.at_vertices(x[: refined.before])
    if ((x - carried) ** 2).sum(axis=1).max() < (LEAST * entry.session.model.mesh.size) ** 2:
        return None
    a, b, c = x[entry.triangles].transpose(1, 0, 2)
    across, normals = np.cross(b - a, c - a), np.zeros_like(x)
    for corner in entry.triangles.T:
        np.add.at(normals, corner, across)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    given = x / entry.link.scale, carried / entry.link.scale, normals
    return Dent(*(np.ascontiguousarray(each, np.float32) for each in given))


def draw_dent(body: bpy.types.Object, entry: Any) -> None:
    """Draw the surface of a session in the scene, where it has a dent that its object cannot show."""
    dent = dent_of(entry)
    if dent is None:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = _shader()
    material = body.active_material
    places = {"place": dent.places, "mesh_place": dent.mesh_places, "normal": dent.normals}
    batch = batch_for_shader(shader, "TRIS", places, indices=entry.triangles.astype("i4"))
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    gpu.state.face_culling_set("BACK")
    shader.bind()
    shader.uniform_float("matrix", gpu.matrix.get_projection_matrix() @ gpu.matrix.get_model_view_matrix())
    shader.uniform_float("towards", bpy.context.region_data.view_matrix.inverted().col[2].xyz)
    colour = material.diffuse_color[:3] if material else GREY
    shader.uniform_float("colour", tuple(SHADE * c for c in colour))
    shader.uniform_float("nearer", NEARER)
    batch.draw(shader)
    gpu.state.face_culling_set("NONE")
    gpu.state.depth_mask_set(False)
    gpu.state.depth_test_set("NONE")


def _shader() -> Any:
    """Return the shader, made when it is needed first."""
    import gpu

    if not _shaders:
        between = gpu.types.GPUStageInterfaceInfo("dimple_dent")
        between.smooth("FLOAT", "facing")
        info = gpu.types.GPUShaderCreateInfo()
        for kind, name in (("MAT4", "matrix"), ("VEC3", "towards"), ("VEC3", "colour"), ("FLOAT", "nearer")):
            info.push_constant(kind, name)
        for slot, name in enumerate(("place", "mesh_place", "normal")):
            info.vertex_in(slot, "VEC3", name)
        info.vertex_out(between)
        info.fragment_out(0, "VEC4", "shown")
        info.vertex_source(_VERTEX)
        info.fragment_source(_FRAGMENT)
        _shaders.append(gpu.shader.create_from_info(info))
    return _shaders[0]
