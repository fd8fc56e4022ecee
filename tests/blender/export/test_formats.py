"""What is exported is read back by an independent reader: the same vertices, faces, times and axes."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tools.environment import ROOT, provide_readers

FIRST, LAST, FPS = 5, 16, 25
EVERY = {"ALEMBIC", "USD", "GLB", "FBX", "PC2", "MDD", "STL", "PLY", "VAT"}
FINEST = 1e-6  # of the size of the object: what is left of it in single precision, added and taken away once


class Exported:
    """One export of all formats: the folder, and what the object did."""

    def __init__(self, folder: Path, local: np.ndarray, world: np.ndarray, corners: np.ndarray, counts: np.ndarray):
        self.folder, self.local, self.world, self.corners, self.counts = folder, local, world, corners, counts
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


@pytest.fixture(scope="module")
def exported(bpy: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Exported]:
    """Everything, exported once from a bake that plays, at an odd frame rate and first frame."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene, folder = bpy.context.scene, tmp_path_factory.mktemp("exported")
    scene.render.fps, scene.dimple.cache_dir = FPS, str(folder / "caches")
    obj = carried(bpy)
    bpy.ops.dimple.bake(frame_start=FIRST, frame_end=LAST)
    from bl_ext.user_default.dimple.core.recording import read_point_cache

    _, _, local = read_point_cache(obj.modifiers[0].filepath)
    world = []
    for frame, sample in zip(range(FIRST, LAST + 1), local, strict=True):
        scene.frame_set(frame)
        matrix = np.array(obj.matrix_world)
        world.append(sample.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])
    corners, counts = np.empty(len(obj.data.loops), np.int32), np.empty(len(obj.data.polygons), np.int32)
    obj.data.loops.foreach_get("vertex_index", corners)
    obj.data.polygons.foreach_get("loop_total", counts)
    scene.frame_set(9)
    before = _state(bpy, obj)
    out = folder / "out"
    assert bpy.ops.dimple.export_animation(
        directory=str(out), formats=EVERY, frame_start=FIRST, frame_end=LAST
    ) == {"FINISHED"}
    assert _state(bpy, obj) == before, "an export changes nothing in the file"
    yield Exported(out, local.astype(np.float64), np.array(world), corners, counts)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _state(bpy: ModuleType, obj: Any) -> Any:
    scene = bpy.context.scene
    return (
        scene.frame_current, scene.frame_start, scene.frame_end, [each.name for each in bpy.context.selected_objects],
        bpy.context.view_layer.objects.active, obj.data.name, [m.name for m in bpy.data.meshes], obj.data.shape_keys,
        [(m.name, m.show_viewport, m.show_render) for m in obj.modifiers], [a.name for a in bpy.data.actions],
        [layer.name for layer in obj.data.uv_layers],
    )  # fmt: skip


@pytest.fixture(scope="session")
def read_back(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], dict[str, np.ndarray]]:
    """Return a function that reads a file by a library that is not Blender's, in a process of its own."""
    readers = provide_readers(Path(sys.executable))

    def read(path: Path) -> dict[str, np.ndarray]:
        out = tmp_path_factory.mktemp("read") / "out.npz"
        command = [sys.executable, str(ROOT / "tests/blender/export/read_back.py"), str(path), str(out)]
        done = subprocess.run(command, env={"PYTHONPATH": str(readers)}, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        with np.load(out) as found:
            return dict(found)

    return read


def worst(found: np.ndarray, wanted: np.ndarray) -> float:
    assert found.shape == wanted.shape
    return float(np.linalg.norm(found - wanted, axis=-1).max())


def nearest(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return which vertex (n,) of the wanted first sample each of the found ones is; a format may split vertices."""
    apart = np.linalg.norm(found[:, None] - wanted[None], axis=-1)
    return apart.argmin(axis=1)


def imported(bpy: ModuleType, take: Callable[[], Any]) -> Any:
    """Import into an empty file of the same frame rate and return the mesh object."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = FPS
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


def test_the_press_that_is_exported_is_one(exported: Exported) -> None:
    assert np.abs(exported.local - exported.local[0]).max() > 0.1


def test_usd_core_reads_every_vertex_of_the_usd(exported: Exported, read_back: Any) -> None:
    found = read_back(exported.folder / "Cushion.usdc")
    assert worst(found["local"], exported.local) <= FINEST * exported.size
    assert worst(found["points"], exported.world) <= FINEST * exported.world_size
    assert found["frame_rate"] == FPS and found["range"].tolist() == [FIRST, LAST]
    assert np.allclose(found["times"] * FPS, np.arange(FIRST, LAST + 1))
    assert found["corners"].tolist() == exported.corners.tolist()
    assert found["counts"].tolist() == exported.counts.tolist()
    assert found["up"] == "Z" and found["unit"] == 1


def test_pygltflib_reads_every_vertex_of_the_glb(exported: Exported, read_back: Any) -> None:
    found = read_back(exported.folder / "Cushion.glb")
    assert np.allclose(found["times"], np.arange(LAST - FIRST + 1) / FPS, atol=1e-6), "it begins at 0 s"
    local = found["local"][..., [0, 2, 1]] * (1, -1, 1)  # Y up to Z up
    which = nearest(local[0], exported.local[0])
    assert set(which) == set(range(exported.local.shape[1]))
    assert worst(local, exported.local[:, which]) <= FINEST * exported.size
    assert len(found["corners"]) == 3 * (exported.counts - 2).sum(), "as many triangles as the faces have"
    place = found["translation"]
    assert np.allclose(place[[0, -1]][:, [0, 2, 1]] * (1, -1, 1), [(3, -2, 1), (3.4, -2, 1)], atol=1e-5)


def test_blender_reads_the_glb_as_it_was(bpy: ModuleType, exported: Exported) -> None:
    path = str(exported.folder / "Cushion.glb")
    obj = imported(bpy, lambda: bpy.ops.import_scene.gltf(filepath=path))
    # a second of Blender's glTF import is a second of frames from 0
    found = seen(bpy, obj, range(LAST - FIRST + 1))
    which = nearest(found[0], exported.world[0])
    # a place turned into a quaternion and back adds a rounding of its own
    assert worst(found, exported.world[:, which]) <= 2 * FINEST * exported.world_size


def test_blender_reads_the_alembic_as_it_was(bpy: ModuleType, exported: Exported) -> None:
    path = str(exported.folder / "Cushion.abc")
    obj = imported(bpy, lambda: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False))
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end) == (FIRST, LAST)
    assert worst(seen(bpy, obj, range(FIRST, LAST + 1)), exported.world) <= FINEST * exported.world_size
    corners, counts = faces(obj)
    assert counts == exported.counts.tolist() and sorted(corners) == sorted(exported.corners.tolist())


def test_blender_reads_the_fbx_as_it_was(bpy: ModuleType, exported: Exported) -> None:
    path = str(exported.folder / "Cushion.fbx")
    obj = imported(bpy, lambda: bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0))
    found = seen(bpy, obj, range(FIRST, LAST + 1))
    assert worst(found, exported.world) <= FINEST * exported.world_size
    assert faces(obj) == (exported.corners.tolist(), exported.counts.tolist())


@pytest.mark.parametrize(("ending", "cache_format"), [(".pc2", "PC2"), (".mdd", "MDD")])
def test_blenders_mesh_cache_plays_the_point_caches(
    bpy: ModuleType, exported: Exported, ending: str, cache_format: str
) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps = FPS
    mesh = bpy.data.meshes.new("Cloud")
    mesh.from_pydata([(0, 0, 0)] * exported.local.shape[1], [], [])
    obj = bpy.data.objects.new("Cloud", mesh)
    scene.collection.objects.link(obj)
    modifier = obj.modifiers.new("Cache", "MESH_CACHE")
    modifier.cache_format, modifier.filepath = cache_format, str(exported.folder / f"Cushion{ending}")
    modifier.frame_start = FIRST
    assert worst(seen(bpy, obj, range(FIRST, LAST + 1)), exported.local) == 0


@pytest.mark.parametrize("ending", ["stl", "ply"])
def test_trimesh_reads_every_file_of_the_sequences(exported: Exported, ending: str) -> None:
    import trimesh

    folder = exported.folder / f"Cushion_{ending}"
    names = [f"Cushion_{frame:04d}.{ending}" for frame in range(FIRST, LAST + 1)]
    assert sorted(path.name for path in folder.iterdir()) == names
    for name, world in zip(names, exported.world, strict=True):
        found = trimesh.load(folder / name, process=False)
        which = nearest(found.vertices, world)
        assert worst(np.array(found.vertices), world[which]) <= FINEST * exported.world_size
        assert len(found.faces) == (exported.counts - 2).sum()
        if ending == "ply":
            assert which.tolist() == list(range(len(world)))


@pytest.mark.parametrize(("picture", "bits"), [("offsets.exr", 32), ("offsets.png", 16)])
def test_blender_reads_every_vertex_from_the_textures(
    bpy: ModuleType, exported: Exported, read_back: Any, picture: str, bits: int
) -> None:
    """As a shader would: at the second UV map, moved down by the rows of a frame."""
    folder = exported.folder / "Cushion_vat"
    layout = json.loads((folder / "layout.json").read_text())
    mesh = read_back(folder / "mesh.glb")
    image = bpy.data.images.load(str(folder / picture))
    image.colorspace_settings.name = "Non-Color"
    assert tuple(image.size) == (layout["width"], layout["height"])
    pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(layout["height"], layout["width"], 4)[..., :3].astype(np.float64)  # the bottom row first
    local = exported.local[..., [0, 2, 1]] * (1, 1, -1)  # Y up, as the mesh is
    which = nearest(mesh["basis"], local[0])
    u, v = mesh["uv"].T.astype(np.float64)  # glTF counts v from the top
    quantum = (layout["most"] - layout["least"]) / 131070 if bits == 16 else 0.0
    for frame, wanted in enumerate(local):
        column = np.floor(u * layout["width"]).astype(int)
        row = np.floor((1 - v - frame * layout["rows"] / layout["height"]) * layout["height"]).astype(int)
        offset = pixels[row, column]
        if bits == 16:
            offset = layout["least"] + offset * (layout["most"] - layout["least"])
        error = np.abs(mesh["basis"] + offset - wanted[which]).max()
        assert error <= 1.01 * quantum + FINEST * exported.size
    bpy.data.images.remove(image)


def test_the_json_says_what_the_files_are(exported: Exported) -> None:
    import hashlib

    said = json.loads((exported.folder / "Cushion.json").read_text())
    assert said["frames"] == [FIRST, LAST] and said["frame_rate"] == FPS and said["seeds"] == []
    assert said["vertices"] == exported.local.shape[1]
    assert said["metres_per_scene_unit"] == pytest.approx(0.165 / exported.world_size, rel=0.2)
    for name in ("Cushion.abc", "Cushion.usdc", "Cushion.glb", "Cushion.fbx", "Cushion.pc2", "Cushion.mdd"):
        data = (exported.folder / name).read_bytes()
        file = said["files"][name]
        assert file["bytes"] == len(data) and file["sha256"] == hashlib.sha256(data).hexdigest()
    assert {"Cushion_stl", "Cushion_ply", "Cushion_vat"} < set(said["files"])
    rows = (exported.folder / "Cushion.csv").read_text().splitlines()
    assert len(rows) == 1 + LAST - FIRST + 1 and rows[1].startswith(f"{FIRST},")


@pytest.mark.parametrize("percent", [1.0, 0.01])
def test_few_shape_keys_play_the_press_within_the_error_that_is_said(
    bpy: ModuleType, exported: Exported, read_back: Any, tmp_path: Path, percent: float
) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps = FPS
    carried(bpy)
    bpy.ops.dimple.export_animation(
        directory=str(tmp_path), formats={"GLB", "FBX"}, frame_start=FIRST, frame_end=LAST, key_error=percent
    )
    said = json.loads((tmp_path / "Cushion.json").read_text())["files"]["Cushion.glb"]
    found = read_back(tmp_path / "Cushion.glb")
    local = found["local"][..., [0, 2, 1]] * (1, -1, 1)
    which = nearest(local[0], exported.local[0])
    error = worst(local, exported.local[:, which])
    assert error <= percent / 100 * exported.size + FINEST * exported.size
    assert error == pytest.approx(said["worst_vertex_error"], abs=FINEST * exported.size)
    assert 0 < said["shape_keys"] < (6 if percent == 1 else LAST - FIRST + 1)
    obj = imported(bpy, lambda: bpy.ops.import_scene.fbx(filepath=str(tmp_path / "Cushion.fbx"), anim_offset=0.0))
    assert worst(seen(bpy, obj, range(FIRST, LAST + 1)), exported.world) <= 1.3 * (
        said["worst_vertex_error"] + FINEST * exported.world_size
    ), "the object is 1.2 times as large in the scene"


@pytest.mark.parametrize("picture", ["offsets.exr", "offsets.png"])
def test_the_sample_nodes_play_the_texture_in_blender(bpy: ModuleType, exported: Exported, picture: str) -> None:
    from blend_samples.vertex_texture import play

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = FPS
    folder = exported.folder / "Cushion_vat"
    obj = play(folder, picture=picture, first=FIRST)
    layout = json.loads((folder / "layout.json").read_text())
    quantum = (layout["most"] - layout["least"]) / 131070 if picture.endswith("png") else 0.0
    # single precision in the nodes, where a number becomes a colour and a length again
    finest = 4 * FINEST * exported.size + 2 * quantum
    which: Any = None
    for frame, wanted in zip(range(FIRST, LAST + 1), exported.local, strict=True):
        bpy.context.scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        found = np.array([vertex.co for vertex in evaluated.vertices])
        which = nearest(found, wanted) if which is None else which
        assert worst(found, wanted[which]) <= finest
