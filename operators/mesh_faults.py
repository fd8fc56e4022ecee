"""Faults of a mesh that are repaired where an artist agrees: doubled and loose vertices, faces that look inward."""

from typing import TYPE_CHECKING, NamedTuple

import bpy

if TYPE_CHECKING:
    import bmesh

SAME = 1e-6  # of the size: vertices that are no farther apart are one


class Faults(NamedTuple):
    """How many vertices are doubled or loose, and how many faces look inward."""

    doubled: int = 0
    loose: int = 0
    inward: int = 0


def repair(obj: bpy.types.Object) -> Faults:
    """Weld doubled vertices, delete loose ones and turn faces outward; return what was done."""
    import bmesh

    mesh = bmesh.new()
    try:
        mesh.from_mesh(obj.data)
        size = max(obj.dimensions) / max(*map(abs, obj.matrix_world.to_scale()), 1e-30)
        pairs = bmesh.ops.find_doubles(mesh, verts=mesh.verts, dist=SAME * size)["targetmap"]
        bmesh.ops.weld_verts(mesh, targetmap=pairs)
        loose = [vertex for vertex in mesh.verts if not vertex.link_faces]
        found = Faults(len(pairs), len(loose), _turn_outward(mesh))
        bmesh.ops.delete(mesh, geom=loose, context="VERTS")
        mesh.to_mesh(obj.data)
        obj.data.update()
        return found
    finally:
        mesh.free()


def _turn_outward(mesh: "bmesh.types.BMesh") -> int:
    """Turn faces outward; return how many. Which side of an open mesh is outward nobody knows: most faces decide."""
    import bmesh

    mesh.normal_update()
    before = [face.normal.copy() for face in mesh.faces]
    bmesh.ops.recalc_face_normals(mesh, faces=mesh.faces)
    mesh.normal_update()
    turned = [face for face, normal in zip(mesh.faces, before, strict=True) if face.normal.dot(normal) < 0]
    is_open = any(edge.is_boundary for edge in mesh.edges)
    if is_open and 2 * len(turned) > len(before):
        bmesh.ops.reverse_faces(mesh, faces=mesh.faces)
        return len(before) - len(turned)
    return len(turned)
