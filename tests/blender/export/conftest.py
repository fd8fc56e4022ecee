"""What the tests of exports share with those of the operators; and one export of everything, read by many."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.export.reading import EVERY, FIRST, FPS, LAST, Exported, carried
from tests.blender.operators.conftest import add, ball, coordinates, pressed, scene, shown
from tests.point_cache import cache_of, read_point_cache
from tools.environment import ROOT, provide_readers

__all__ = ["add", "ball", "coordinates", "pressed", "scene", "shown"]


@pytest.fixture(scope="session")
def exported(bpy: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Exported]:
    """Everything, exported once from a bake that plays, at an odd frame rate and first frame."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene, folder = bpy.context.scene, tmp_path_factory.mktemp("exported")
    scene.render.fps, scene.dimple.cache_dir = FPS, str(folder / "caches")
    obj = carried(bpy)
    bpy.ops.dimple.bake(frame_start=FIRST, frame_end=LAST)
    rest = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", rest)
    local = rest.reshape(-1, 3) + read_point_cache(cache_of(obj).filepath)[2]
    world, normals = [], []
    for frame, sample in zip(range(FIRST, LAST + 1), local, strict=True):
        scene.frame_set(frame)
        matrix = np.array(obj.matrix_world)
        world.append(sample.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        now = np.empty(3 * len(mesh.loops), np.float32)
        mesh.corner_normals.foreach_get("vector", now)
        normals.append(now.reshape(-1, 3).astype(np.float64))
    corners, counts = np.empty(len(obj.data.loops), np.int32), np.empty(len(obj.data.polygons), np.int32)
    obj.data.loops.foreach_get("vertex_index", corners)
    obj.data.polygons.foreach_get("loop_total", counts)
    scene.frame_set(9)
    before = _state(bpy, obj)
    out = folder / "out"
    assert bpy.ops.dimple.export_animation(
        directory=str(out), formats=set(EVERY), frame_start=FIRST, frame_end=LAST
    ) == {"FINISHED"}
    assert _state(bpy, obj) == before, "an export changes nothing in the file"
    yield Exported(out, local.astype(np.float64), np.array(world), np.array(normals), corners, counts)
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
