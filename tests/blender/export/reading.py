"""What the tests of exports share: the body that is exported, and how what was written is compared with it."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

FIRST, LAST, FPS = 5, 16, 25
EVERY = ("ALEMBIC", "USD", "GLB", "FBX", "PC2", "VAT")
ENDINGS = (".abc", "_usd", ".glb", ".fbx", ".pc2", "_vat")
RIGHT = 0.1  # [degrees] of a normal: rounding of the deep dent's small faces
FINEST = 1e-6  # of the size of the object: what is left of it in single precision, added and taken away once


class Exported:
    """One export of all formats: the folder, and what the object did."""

    def __init__(
        self, folder: Path, local: np.ndarray, world: np.ndarray, normals: np.ndarray, corners: np.ndarray,
        counts: np.ndarray,
    ):  # fmt: skip
        self.folder, self.local, self.world, self.normals = folder, local, world, normals
        self.corners, self.counts = corners, counts
        self.size = float(np.ptp(local[0], axis=0).max())
        self.world_size = float(np.ptp(world[0], axis=0).max())


def carried(bpy: ModuleType) -> Any:
    """Add a cube of quads and triangles with a UV map that is carried, turned and pressed; unevenly scaled."""
    import bmesh

    mesh = bpy.data.meshes.new("Cushion")
    made = bmesh.new()
    bmesh.ops.create_cube(made, size=2.0, calc_uvs=True)
    bmesh.ops.subdivide_edges(made, edges=made.edges[:], cuts=4, use_grid_fill=True)
    bmesh.ops.triangulate(made, faces=made.faces[:20])
    made.to_mesh(mesh)
    made.free()
    obj = bpy.data.objects.new("Cushion", mesh)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    obj.dimple.size_mode, obj.dimple.simulated = "CUSTOM", "MESH"
    obj.location, obj.scale, obj.rotation_euler = (3, -2, 1), (1, 0.8, 1.2), (0.2, 0.1, 0.4)
    for frame, x in ((FIRST, 3.0), (LAST, 3.4)):
        obj.location.x = x
        obj.keyframe_insert("location", frame=frame)
    bpy.ops.dimple.add_fingertip()
    tip = bpy.context.scene.dimple.finger_1
    top = tip.location.z
    for frame, height in ((FIRST, top), (FIRST + 6, top - 0.25), (LAST, top - 0.05)):
        tip.location.z = height
        tip.keyframe_insert("location", frame=frame)
    for each in bpy.context.selected_objects:
        each.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


def worst(found: np.ndarray, wanted: np.ndarray) -> float:
    assert found.shape == wanted.shape
    return float(np.linalg.norm(found - wanted, axis=-1).max())


def angle(found: np.ndarray, wanted: np.ndarray) -> float:
    """Return the largest angle [degrees] between normals."""
    return float(angles(found, wanted).max())


def angles(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    a, b = (each / np.linalg.norm(each, axis=-1, keepdims=True) for each in (found, wanted))
    return np.degrees(2 * np.arcsin(np.minimum(np.linalg.norm(a - b, axis=-1) / 2, 1)))


def split_angle(found: np.ndarray, which: np.ndarray, exported: Exported) -> float:
    """Return how far normals (frames, n, 3) of split vertices are off, each beside that corner of its vertex (n,) from
    which it is least off throughout."""
    return max(
        angles(found[:, [number]], exported.normals[:, exported.corners == vertex]).max(axis=0).min()
        for number, vertex in enumerate(which)
    )


def nearest(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return which vertex (n,) of the wanted first sample each of the found ones is; a format may split vertices."""
    apart = np.linalg.norm(found[:, None] - wanted[None], axis=-1)
    return apart.argmin(axis=1)


def imported(bpy: ModuleType, take: Callable[[], Any], fps: float = FPS) -> Any:
    """Import into an empty file of the same frame rate and return the mesh object."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = fps
    assert take() == {"FINISHED"}
    (obj,) = (each for each in bpy.context.scene.objects if each.type == "MESH")
    return obj


def seen(bpy: ModuleType, obj: Any, frames: range) -> np.ndarray:
    """Return where the vertices are in the scene, (frames, vertices, 3), as Blender evaluates them."""
    result = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        numbers = np.empty(3 * len(evaluated.data.vertices), np.float32)
        evaluated.data.vertices.foreach_get("co", numbers)
        matrix = np.array(evaluated.matrix_world)
        result.append(numbers.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])
    return np.array(result)


def faces(obj: Any) -> tuple[list[int], list[int]]:
    return [loop.vertex_index for loop in obj.data.loops], [polygon.loop_total for polygon in obj.data.polygons]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def earlier(folder: Path) -> dict[str, bytes]:
    """Put something under every name that an export of the ball takes, and return it."""
    folder.mkdir()
    for ending in (*ENDINGS, ".csv", ".json"):
        if "." in ending:
            (folder / f"Ball{ending}").write_text(f"an earlier {ending}")
        else:
            (folder / f"Ball{ending}").mkdir()
            (folder / f"Ball{ending}" / "earlier").write_text(f"an earlier {ending}")
    return contents(folder)


def is_whole(path: Path) -> bool:
    """Return whether a file is complete by its own header."""
    if not path.is_file():
        return False
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(4096)
    if path.suffix == ".abc":  # set when an Ogawa archive is closed
        return head[:6] == b"Ogawa\xff"
    if path.suffix == ".usdc":  # the table of contents is written last
        return len(head) >= 24 and 24 <= int.from_bytes(head[16:24], "little") < size
    if path.suffix == ".glb":
        return int.from_bytes(head[8:12], "little") == size
    return size > 0
