"""What the operators' tests share: bodies to press, and their coordinates bit for bit."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


@pytest.fixture
def add(empty_file: ModuleType) -> Callable[..., Any]:
    """Return a function that adds a mesh object that stands for one of 165 mm, and selects it alone."""
    bpy = empty_file

    def add_mesh(points: Any = CUBE, faces: Any = FACES, name: str = "Body") -> Any:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(points, [], faces)
        obj = bpy.data.objects.new(name, mesh)
        bpy.context.collection.objects.link(obj)
        for other in bpy.context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        obj.dimple.size_mode = "CUSTOM"
        return obj

    return add_mesh


@pytest.fixture
def ball(add: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that adds a ball of 42 vertices and radius 1 that stands for one of 165 mm."""
    import bmesh

    def add_ball(name: str = "Ball") -> Any:
        obj = add([], [], name)
        made = bmesh.new()
        bmesh.ops.create_icosphere(made, subdivisions=2, radius=1.0)
        made.to_mesh(obj.data)
        made.free()
        return obj

    return add_ball


@pytest.fixture
def coordinates() -> Callable[[Any], bytes]:
    """Return a function that reads the coordinates of a mesh bit for bit."""

    def read(obj: Any) -> bytes:
        numbers = np.empty(3 * len(obj.data.vertices), np.float32)
        obj.data.vertices.foreach_get("co", numbers)
        return numbers.tobytes()

    return read


@pytest.fixture
def shown(bpy: ModuleType) -> Callable[[Any], np.ndarray]:
    """Return a function that reads the evaluated coordinates (n, 3) of an object: what one sees."""

    def read(obj: Any) -> np.ndarray:
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        numbers = np.empty(3 * len(evaluated.vertices), np.float32)
        evaluated.vertices.foreach_get("co", numbers)
        return numbers.reshape(-1, 3)

    return read
