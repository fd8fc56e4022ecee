"""What leaves Blender arrives elsewhere: at the right time, in the right size, with its pictures, all formats alike."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.export.reading import EVERY, FINEST, imported, seen, worst
from tests.point_cache import read_point_cache

FIRST, LAST = 3, 11
COUNT = LAST - FIRST + 1


def export(bpy: ModuleType, folder: Path, **options: Any) -> dict[str, Any]:
    bpy.ops.dimple.export_animation(
        directory=str(folder), formats=set(EVERY), frame_start=FIRST, frame_end=LAST, **options
    )
    return json.loads((folder / "Ball.json").read_text())


@pytest.mark.parametrize(("fps", "base"), [(24, 1.001), (50, 2.0)])
def test_a_second_is_a_second_at_every_frame_rate(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], read_back: Any, tmp_path: Path, fps: int, base: float
) -> None:
    obj = pressed()
    scene.render.fps, scene.render.fps_base = fps, base
    bpy.ops.dimple.bake(frame_start=FIRST, frame_end=LAST)
    wanted = seen(bpy, obj, range(FIRST, LAST + 1))
    said = export(bpy, tmp_path)
    assert scene.render.fps == fps and scene.render.fps_base == pytest.approx(base)
    times = np.arange(COUNT) * base / fps
    assert said["frame_rate"] == pytest.approx(fps / base, rel=1e-6)
    assert read_back(tmp_path / "Ball.glb")["times"] == pytest.approx(times, rel=1e-5)
    usd = read_back(tmp_path / "Ball_usd" / "Ball.usdc")
    assert usd["times"] - usd["times"][0] == pytest.approx(times, rel=1e-5)
    assert usd["shown_rate"] == pytest.approx(fps / base, rel=1e-6)
    assert json.loads((tmp_path / "Ball_vat/layout.json").read_text())["frame_rate"] == pytest.approx(fps / base)

    def take() -> Any:  # by ufbx, which Blender did not write
        bpy.context.scene.render.fps_base = base
        return bpy.ops.wm.fbx_import(filepath=str(tmp_path / "Ball.fbx"), anim_offset=0.0)

    found = imported(bpy, take, fps)
    assert worst(seen(bpy, found, range(COUNT)), wanted) < 2 * FINEST * float(np.ptp(wanted[0], axis=0).max())


def test_a_centimetre_is_a_centimetre(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], read_back: Any, tmp_path: Path
) -> None:
    obj = pressed()
    scene.unit_settings.scale_length = 0.01
    size = 0.01 * max(obj.dimensions)
    export(bpy, tmp_path)
    usd = read_back(tmp_path / "Ball_usd" / "Ball.usdc")
    assert usd["unit"] * np.ptp(usd["points"][0], axis=0).max() == pytest.approx(size, rel=1e-5)
    for name in ("Ball.glb", "Ball_vat/mesh.glb"):
        found = read_back(tmp_path / name)
        assert found["root"][0] * np.ptp(found["basis"], axis=0).max() == pytest.approx(size, rel=1e-5)
    fbx = imported(bpy, lambda: bpy.ops.wm.fbx_import(filepath=str(tmp_path / "Ball.fbx")))
    assert max(fbx.dimensions) == pytest.approx(size, rel=1e-5)


def test_the_node_of_an_fbx_has_the_scale_of_the_object(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    from io_scene_fbx import parse_fbx

    obj = pressed()
    obj.scale = (2, 2, 2)
    export(bpy, tmp_path)
    root, _ = parse_fbx.parse(str(tmp_path / "Ball.fbx"))

    def inside(element: Any, name: bytes) -> list[Any]:
        return [each for each in element.elems if each.id == name]

    (model,) = inside(inside(root, b"Objects")[0], b"Model")
    (scale,) = (each.props[4:] for each in inside(model, b"Properties70")[0].elems if each.props[0] == b"Lcl Scaling")
    assert scale == pytest.approx([2, 2, 2]), "and not 200, of which an engine would make a transform"


def test_pictures_go_along_when_the_blend_file_is_gone(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], read_back: Any, tmp_path: Path
) -> None:
    obj = pressed()
    obj.data.uv_layers.new(name="UVMap")
    scene.world = bpy.data.worlds.new("World")
    for name in ("Packed", "Beside"):
        image = bpy.data.images.new(name, 4, 4)
        image.pixels.foreach_set([0.5] * 64)
        if name == "Packed":  # as one that is painted in Blender: it has no path
            image.pack()
        else:
            image.filepath_raw, image.file_format = str(tmp_path / f"{name}.png"), "PNG"
            image.save()
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        texture, tree = material.node_tree.nodes.new("ShaderNodeTexImage"), material.node_tree
        texture.image = image
        shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
        tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
        obj.data.materials.append(material)
    obj.data.polygons.foreach_set("material_index", [number % 2 for number in range(len(obj.data.polygons))])
    export(bpy, tmp_path / "out")
    moved = (tmp_path / "out").rename(tmp_path / "elsewhere")
    (tmp_path / "Beside.png").unlink()
    usd = read_back(moved / "Ball_usd" / "Ball.usdc")
    assert usd["faults"].tolist() == [] and usd["lights"] == 0
    assert sorted(usd["pictures"].tolist()) == ["./textures/Beside.png", "./textures/Packed.png"]
    for name in ("Ball.glb", "Ball_vat/mesh.glb"):
        imported(bpy, lambda: bpy.ops.import_scene.gltf(filepath=str(moved / name)))  # noqa: B023
        assert sum(image.size[0] == 4 for image in bpy.data.images) == 2
    imported(bpy, lambda: bpy.ops.wm.fbx_import(filepath=str(moved / "Ball.fbx")))
    assert {image.name for image in bpy.data.images if image.size[0] == 4} == {"Packed.png", "Beside.png"}


def test_a_texture_moves_as_the_parent_of_its_object_does(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path
) -> None:
    obj = pressed()
    obj.parent = bpy.data.objects.new("Holder", None)
    scene.collection.objects.link(obj.parent)
    for frame, x, turn in ((FIRST, 0.0, 0.0), (LAST, 2.0, 1.0)):
        obj.parent.location.x, obj.parent.rotation_euler.z, obj.parent.scale = x, turn, (2, 2, 2)
        for path in ("location", "rotation_euler"):
            obj.parent.keyframe_insert(path, frame=frame)
    bpy.ops.dimple.bake(frame_start=FIRST, frame_end=LAST)
    wanted = []
    for frame in range(FIRST, LAST + 1):
        scene.frame_set(frame)
        wanted.append(np.array(obj.matrix_world))
    export(bpy, tmp_path)
    path = str(tmp_path / "Ball_vat/mesh.glb")
    found = imported(bpy, lambda: bpy.ops.import_scene.gltf(filepath=path), scene.render.fps)
    for frame, matrix in enumerate(wanted):
        bpy.context.scene.frame_set(frame)
        assert np.abs(np.array(found.matrix_world) - matrix).max() < 1e-5


@pytest.mark.parametrize("modifiers", ["VIEWPORT", "RENDER"])
def test_all_formats_hold_one_mesh_as_it_is_seen_or_rendered(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], read_back: Any, tmp_path: Path, modifiers: str
) -> None:
    obj = pressed()
    finer = obj.modifiers.new("Subdivision", "SUBSURF")
    finer.levels, finer.render_levels, fps = 1, 2, scene.render.fps
    bpy.ops.dimple.bake(frame_start=FIRST, frame_end=LAST)
    if modifiers == "RENDER":
        finer.levels = 2
    wanted = seen(bpy, obj, range(FIRST, LAST + 1))
    finer.levels = 1
    said = export(bpy, tmp_path, modifiers=modifiers)
    assert finer.levels == 1 and finer.render_levels == 2
    count, size = wanted.shape[1], float(np.ptp(wanted[0], axis=0).max())
    assert count == said["files"]["Ball.abc"]["vertices"] == {"VIEWPORT": 242, "RENDER": 962}[modifiers]
    assert modifiers.lower() in said["mesh"]
    assert np.abs(wanted - wanted[0]).max() > 0.05, "it is pressed"
    assert worst(read_point_cache(tmp_path / "Ball.pc2")[2], wanted) <= FINEST * size
    assert worst(read_back(tmp_path / "Ball_usd" / "Ball.usdc")["points"], wanted) <= FINEST * size
    glb = read_back(tmp_path / "Ball.glb")["local"]
    assert len(np.unique(np.round(glb[0], 5), axis=0)) == count
    path = str(tmp_path / "Ball.abc")
    alembic = imported(bpy, lambda: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False), fps)
    assert worst(seen(bpy, alembic, range(FIRST, LAST + 1)), wanted) <= FINEST * size
    fbx = imported(bpy, lambda: bpy.ops.wm.fbx_import(filepath=str(tmp_path / "Ball.fbx"), anim_offset=0.0))
    assert len(fbx.data.vertices) == count
