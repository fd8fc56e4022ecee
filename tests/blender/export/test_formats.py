"""What is exported is read back by an independent reader: the same vertices, faces, times and axes."""

import json
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.export.reading import (
    FINEST,
    FIRST,
    FPS,
    LAST,
    RIGHT,
    Exported,
    angle,
    faces,
    imported,
    nearest,
    seen,
    split_angle,
    worst,
)


def test_the_press_that_is_exported_is_one(exported: Exported) -> None:
    assert np.abs(exported.local - exported.local[0]).max() > 0.1


def test_usd_core_reads_every_vertex_of_the_usd(exported: Exported, read_back: Any) -> None:
    found = read_back(exported.folder / "Cushion_usd" / "Cushion.usdc")
    assert worst(found["local"], exported.local) <= FINEST * exported.size
    assert worst(found["points"], exported.world) <= FINEST * exported.world_size
    assert found["frame_rate"] == FPS and found["range"].tolist() == [FIRST, LAST]
    assert np.allclose(found["times"] * FPS, np.arange(FIRST, LAST + 1))
    assert found["corners"].tolist() == exported.corners.tolist()
    assert found["counts"].tolist() == exported.counts.tolist()
    assert found["up"] == "Z" and found["unit"] == 1 and found["shown_rate"] == FPS
    assert angle(found["normals"], exported.normals) < RIGHT
    assert found["faults"].tolist() == [], "usd-core finds nothing wrong, no picture that is nowhere"


def test_pygltflib_reads_every_vertex_of_the_glb(exported: Exported, read_back: Any) -> None:
    found = read_back(exported.folder / "Cushion.glb")
    assert np.allclose(found["times"], np.arange(LAST - FIRST + 1) / FPS, atol=1e-6), "it begins at 0 s"
    local = found["local"][..., [0, 2, 1]] * (1, -1, 1)  # Y up to Z up
    which = nearest(local[0], exported.local[0])
    assert set(which) == set(range(exported.local.shape[1]))
    assert worst(local, exported.local[:, which]) <= FINEST * exported.size
    assert len(found["corners"]) == 3 * (exported.counts - 2).sum(), "as many triangles as the faces have"
    normals = found["normals"][..., [0, 2, 1]] * (1, -1, 1)
    assert split_angle(normals, which, exported) < RIGHT
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
    found = seen(bpy, obj, range(LAST - FIRST + 1))
    assert worst(found, exported.world) <= FINEST * exported.world_size
    assert faces(obj) == (exported.corners.tolist(), exported.counts.tolist())


def test_blenders_mesh_cache_plays_the_point_cache(bpy: ModuleType, exported: Exported) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps = FPS
    mesh = bpy.data.meshes.new("Cloud")
    mesh.from_pydata([(0, 0, 0)] * exported.local.shape[1], [], [])
    obj = bpy.data.objects.new("Cloud", mesh)
    scene.collection.objects.link(obj)
    modifier = obj.modifiers.new("Cache", "MESH_CACHE")
    modifier.cache_format, modifier.filepath = "PC2", str(exported.folder / "Cushion.pc2")
    modifier.frame_start = FIRST
    assert worst(seen(bpy, obj, range(FIRST, LAST + 1)), exported.local) == 0


def test_the_json_says_what_the_files_are(exported: Exported) -> None:
    said = json.loads((exported.folder / "Cushion.json").read_text())
    assert said["frames"] == [FIRST, LAST] and said["frame_rate"] == FPS
    assert said["metres_per_scene_unit"] == pytest.approx(0.165 / exported.world_size, rel=0.2)
    for name in ("Cushion.abc", "Cushion.glb", "Cushion.fbx", "Cushion.pc2"):
        assert said["files"][name]["vertices"] == exported.local.shape[1]
    assert {"Cushion_usd", "Cushion_vat"} < set(said["files"])
    starts = {file["format"]: file["time_0_is_frame"] for file in said["files"].values()}
    assert starts["glTF"] == starts["FBX"] == FIRST and starts["Alembic"] == starts["USD"] == 0
    rows = (exported.folder / "Cushion.csv").read_text().splitlines()
    assert len(rows) == 1 + LAST - FIRST + 1 and rows[1].startswith(f"{FIRST},")
