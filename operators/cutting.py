"""Cut a mesh finer where it is too coarse to show the dent of a fingertip; its shape stays."""

import math
from typing import TYPE_CHECKING

import bpy

from .sizing import scales_of

if TYPE_CHECKING:
    import bmesh
    import numpy as np

# edges [fingertip radii]: up to the first a dent shows, up to the second it is round; so it is cut where so many
# vertices, which run live, do
SHOWN, ROUND, LIVE = 1.1, 0.55, 8_000
MOST_VERTICES = 40_000  # of a mesh that is subdivided
ROUNDS, EVEN = 7, 1.001  # of cutting edges; by less than that all are as long
ALIKE = 1.5  # times as long as the shortest: an edge that is cut in as many parts, or faces between two get slivers
STRAIGHT = 3.0  # [rad] at a corner
# of the longest edge: between new vertices, from those to the rim of their face, from its corners to its plane
APART, RIM, FLAT = 0.85, 0.5, 0.01
ROUNDING = 1e-5  # of a place that was made real and back


def is_coarse(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Tell whether most edges of a mesh, or of its surface most faces, are wider than the fingertip.

    At the size it has or will get. A cylinder has short edges round its rim, and wide faces.
    """
    import numpy as np

    faces, scales = obj.data.polygons, np.array(scales_of(context.scene, obj))
    if not len(faces):
        return False
    areas, normals = np.empty(len(faces), np.float32), np.empty(3 * len(faces), np.float32)
    faces.foreach_get("area", areas)
    faces.foreach_get("normal", normals)
    across = np.roll(scales, 1) * np.roll(scales, 2)  # how much larger a face across each axis is [m2]
    areas = areas * np.linalg.norm(normals.reshape(-1, 3) * across, axis=1)
    lengths, wide = edge_lengths(obj.data, scales), 2 * context.scene.dimple.finger_radius_mm / 1e3
    return float(np.median(lengths)) > wide or 2 * float(areas[areas > wide**2].sum()) > float(areas.sum())


def is_simulated_finer(scene: bpy.types.Scene, obj: bpy.types.Object) -> bool:
    """Tell whether a mesh is simulated finer than it is, where that is left to Dimple; a bake does not show it."""
    import numpy as np

    from ..core.mesh.refine import is_coarse as hides_dents

    mesh = obj.data
    mesh.calc_loop_triangles()
    points, corners = np.empty(3 * len(mesh.vertices), np.float32), np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.vertices.foreach_get("co", points)
    mesh.loop_triangles.foreach_get("vertices", corners)
    real = np.array(scales_of(scene, obj)) * points.reshape(-1, 3)
    return hides_dents(real, corners.reshape(-1, 3), scene.dimple.finger_radius_mm / 1e3)


def edge_lengths(mesh: bpy.types.Mesh, scales: "np.ndarray") -> "np.ndarray":
    """Return the length (e,) of every edge [m], with metres per unit along each axis (3,)."""
    import numpy as np

    points, ends = np.empty(3 * len(mesh.vertices), np.float32), np.empty(2 * len(mesh.edges), np.int32)
    mesh.vertices.foreach_get("co", points)
    mesh.edges.foreach_get("vertices", ends)
    pairs = (scales * points.reshape(-1, 3))[ends.reshape(-1, 2)]
    return np.linalg.norm(pairs[:, 0] - pairs[:, 1], axis=1)


def refine(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    """Cut the edges of a mesh in even parts until none is too long for the fingertip, at the size the body has."""
    import bmesh
    from mathutils import Matrix

    made, radius = bmesh.new(), scene.dimple.finger_radius_mm / 1e3
    real = Matrix.Diagonal((*scales_of(scene, obj), 1.0))
    try:
        made.from_mesh(obj.data)
        before = [vertex.co.copy() for vertex in made.verts]
        made.transform(real)
        area = sum(face.calc_area() for face in made.faces)
        longest = max(ROUND * radius, min(SHOWN * radius, (area / LIVE) ** 0.5), (area / MOST_VERTICES) ** 0.5)
        for _ in range(ROUNDS):
            long = [edge for edge in made.edges if edge.calc_length() > EVEN * longest]
            shortest = min((edge.calc_length() for edge in long), default=0.0)
            alike = [edge.calc_length() for edge in long if edge.calc_length() < ALIKE * shortest]
            cuts = math.ceil(max(shortest, max(alike, default=0.0) / EVEN) / longest) - 1
            if not long or len(made.verts) + cuts * len(long) > MOST_VERTICES:
                break
            bmesh.ops.subdivide_edges(made, edges=long, cuts=cuts, use_grid_fill=True)
        fill_faces(made, longest)
        uneven = [face for face in made.faces if len(face.verts) > 3 and straight(face)]
        bmesh.ops.triangulate(made, faces=uneven, quad_method="BEAUTY", ngon_method="BEAUTY")
        made.transform(real.inverted())
        for vertex, place in zip(made.verts, before, strict=False):  # new ones come after those there were
            if (vertex.co - place).length < ROUNDING * place.length:
                vertex.co = place  # bit for bit
        made.to_mesh(obj.data)
    finally:
        made.free()
    obj.data.update()


def fill_faces(made: "bmesh.types.BMesh", longest: float) -> None:
    """Cut large flat faces of more than four corners into even triangles: no cut of their edges makes them finer."""
    import numpy as np
    from mathutils.geometry import delaunay_2d_cdt

    for face in [each for each in made.faces if len(each.verts) > 4 and each.calc_area() > longest**2]:
        corners, normal = list(face.verts), np.array(face.normal)
        points = np.array([vertex.co for vertex in corners])
        along = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
        axes = np.stack([along, np.cross(normal, along)]) / np.linalg.norm(along)
        centre = points.mean(axis=0)
        flat, off = (points - centre) @ axes.T, np.abs((points - centre) @ normal).max()
        within = inside(flat, longest)
        if off > FLAT * longest or len(corners) + len(within) > MOST_VERTICES:
            continue
        places, _, triangles, origins, *_ = delaunay_2d_cdt(
            [*map(tuple, flat), *map(tuple, within)], [], [list(range(len(flat)))], 1, 0.0
        )
        here = [corners[each[0]] if each and each[0] < len(corners) else None for each in origins]
        for triangle in triangles:
            for i in triangle:
                here[i] = here[i] or made.verts.new(centre + np.array(places[i]) @ axes)
            made.faces.new([here[i] for i in triangle], face).copy_from_face_interp(face, False)
        made.faces.remove(face)


def straight(face: "bmesh.types.BMFace") -> bool:
    """Tell whether a face has a corner that is none: some triangles of it would have no area."""
    return any(loop.calc_angle() > STRAIGHT for loop in face.loops)


def inside(rim: "np.ndarray", longest: float) -> "np.ndarray":
    """Return an even pattern of points (m, 2) in the rectangle round a rim (n, 2), away from the rim itself."""
    import numpy as np

    low, high = rim.min(axis=0), rim.max(axis=0)
    step = APART * longest
    u, v = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], 0.75**0.5 * step))
    u[1::2] += step / 2  # corners of equilateral triangles
    points = np.stack([u.ravel(), v.ravel()], axis=1)
    nearest = np.full(len(points), np.inf)
    for start, end in zip(rim, np.roll(rim, -1, axis=0), strict=True):
        side = end - start
        share = np.clip((points - start) @ side / max(float(side @ side), 1e-30), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(points - start - share[:, None] * side, axis=1))
    return points[nearest > RIM * longest]
