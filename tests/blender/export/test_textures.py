"""Vertex animation textures are read as a shader reads them, by Blender's pictures and by its nodes."""

import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from tests.blender.export.reading import FINEST, FIRST, FPS, LAST, Exported, nearest, worst


def test_blender_reads_every_vertex_from_the_textures(bpy: ModuleType, exported: Exported, read_back: Any) -> None:
    """As a shader would: at the second UV map, moved down by the rows of a frame."""
    folder = exported.folder / "Cushion_vat"
    layout = json.loads((folder / "layout.json").read_text())
    mesh = read_back(folder / "mesh.glb")
    image = bpy.data.images.load(str(folder / "offsets.exr"))
    image.colorspace_settings.name = "Non-Color"
    assert tuple(image.size) == (layout["width"], layout["height"])
    pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(layout["height"], layout["width"], 4)[..., :3].astype(np.float64)  # the bottom row first
    local = exported.local[..., [0, 2, 1]] * (1, 1, -1)  # Y up, as the mesh is
    which = nearest(mesh["basis"], local[0])
    u, v = mesh["uv"].T.astype(np.float64)  # glTF counts v from the top
    for frame, wanted in enumerate(local):
        column = np.floor(u * layout["width"]).astype(int)
        row = np.floor((1 - v - frame * layout["rows"] / layout["height"]) * layout["height"]).astype(int)
        assert np.abs(mesh["basis"] + pixels[row, column] - wanted[which]).max() <= FINEST * exported.size
    bpy.data.images.remove(image)


def test_the_sample_nodes_play_the_texture_in_blender(bpy: ModuleType, exported: Exported) -> None:
    from blend_samples.vertex_texture import play

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = FPS
    folder = exported.folder / "Cushion_vat"
    obj = play(folder, first=FIRST)
    finest = 4 * FINEST * exported.size  # single precision in the nodes
    which: Any = None
    for frame, wanted in zip(range(FIRST, LAST + 1), exported.local, strict=True):
        bpy.context.scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        found = np.array([vertex.co for vertex in evaluated.vertices])
        which = nearest(found, wanted) if which is None else which
        assert worst(found, wanted[which]) <= finest


def test_the_sample_material_displaces_as_the_nodes_do(bpy: ModuleType, exported: Exported, tmp_path: Path) -> None:
    """Rendered by Cycles, from the side, where the dent is seen against the background."""
    from mathutils import Vector

    from blend_samples.vertex_texture import displace, play

    folder, pictures = exported.folder / "Cushion_vat", {}
    for name in ("nodes", "material"):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        scene = bpy.context.scene
        obj = play(folder, first=FIRST)
        if name == "material":
            obj.modifiers.clear()
            displace(obj, folder, first=FIRST)
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 3.5
        scene.camera.location, scene.camera.rotation_euler = obj.location - Vector((0, 9, 0)), (np.pi / 2, 0, 0)
        scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
        scene.render.resolution_x = scene.render.resolution_y = 64
        scene.render.film_transparent, scene.render.filepath = True, str(tmp_path / "picture.png")
        for frame in (FIRST, FIRST + 6):
            scene.frame_set(frame)
            scene.camera.location.x = obj.matrix_world.translation.x
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(scene.render.filepath)
            pixels = np.empty(4 * 64 * 64, np.float32)
            image.pixels.foreach_get(pixels)
            bpy.data.images.remove(image)
            pictures[name, frame] = pixels.reshape(-1, 4)[:, 3]  # what covers the background
    moved = np.abs(pictures["nodes", FIRST] - pictures["nodes", FIRST + 6]).sum()
    assert moved > 20, "the dent is seen"
    for frame in (FIRST, FIRST + 6):
        assert np.abs(pictures["nodes", frame] - pictures["material", frame]).sum() < 0.2 * moved
