"""Formats with shape keys: one a frame, one every few, or a few that every frame is a sum of, with the error stated."""

import json
from collections.abc import Callable
from pathlib import Path
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
    carried,
    imported,
    nearest,
    seen,
    split_angle,
    worst,
)
from tests.point_cache import read_point_cache


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
    turned = split_angle(found["normals"][..., [0, 2, 1]] * (1, -1, 1), which, exported)
    assert turned <= 1 + RIGHT, "the dent is shaded as it was"
    assert turned <= said["worst_normal_error_degrees"] + RIGHT
    assert found["weights"].min() >= 0 and found["weights"].max() <= 1, "some programs cut off what is not"
    assert 0 < said["shape_keys"] < (9 if percent == 1 else LAST - FIRST + 1)
    obj = imported(bpy, lambda: bpy.ops.import_scene.fbx(filepath=str(tmp_path / "Cushion.fbx"), anim_offset=0.0))
    assert worst(seen(bpy, obj, range(LAST - FIRST + 1)), exported.world) <= 1.3 * (
        said["worst_vertex_error"] + FINEST * exported.world_size
    ), "the object is 1.2 times as large in the scene"




def test_frames_that_are_alike_share_a_shape_key(bpy: ModuleType, scene: Any, pressed: Callable[..., Any],
                                                 read_back: Any, tmp_path: Path) -> None:
    pressed()
    bpy.ops.dimple.bake(frame_start=3, frame_end=8)
    bpy.ops.dimple.export_animation(directory=str(tmp_path), formats={"GLB"}, frame_start=1, frame_end=12)
    said = json.loads((tmp_path / "Ball.json").read_text())["files"]["Ball.glb"]
    assert said["shape_keys"] <= 5, "six frames are baked, the others show the first or the last of them"
    local = read_back(tmp_path / "Ball.glb")["local"]
    assert np.array_equal(local[0], local[2]) and np.array_equal(local[7], local[11])


@pytest.mark.parametrize("kind", ["USD", "ALEMBIC", "GLB", "FBX"])
def test_an_object_with_shape_keys_of_its_own_is_no_still(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, kind: str
) -> None:
    """Blender's USD exporter writes such an object without what deforms it, unless it is kept from it."""
    obj = pressed()
    for name in ("Basis", "Large"):
        obj.shape_key_add(name=name)
    for point in obj.data.shape_keys.key_blocks["Large"].data:
        point.co *= 1.2
    obj.data.shape_keys.key_blocks["Large"].value = 0.5
    bpy.ops.dimple.export_animation(directory=str(tmp_path), formats={kind, "PC2"}, frame_start=1, frame_end=9)
    wanted = read_point_cache(tmp_path / "Ball.pc2")[2].astype(np.float64)
    assert np.abs(wanted - wanted[0]).max() > 0.05
    path = str(next(tmp_path.rglob(f"Ball.{ {'USD': 'usdc', 'ALEMBIC': 'abc'}.get(kind, kind.lower()) }")))
    fps = scene.render.fps
    found = imported(bpy, {
        "USD": lambda: bpy.ops.wm.usd_import(filepath=path),
        "ALEMBIC": lambda: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False),
        "GLB": lambda: bpy.ops.import_scene.gltf(filepath=path),
        "FBX": lambda: bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0),
    }[kind], fps)  # fmt: skip
    shown = seen(bpy, found, range(9) if kind in ("GLB", "FBX") else range(1, 10))
    which = nearest(shown[0], wanted[0])
    assert worst(shown, wanted[:, which]) <= FINEST * float(np.ptp(wanted[0], axis=0).max())
