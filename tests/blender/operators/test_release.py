"""Blender's own monkey, pressed and let go: no dent stays."""

from types import ModuleType
from typing import Any

import numpy as np
import pytest

PLACES = 12
RADIUS = 0.010  # [m]
LEFT = 1e-4  # [m] that may stay a second later, a fiftieth of the shallow press


@pytest.fixture
def monkey(bpy: ModuleType, empty_file: ModuleType) -> Any:
    """Suzanne as Blender adds her, of 165 mm, of the paper's second object."""
    from bl_ext.user_default.dimple import Body

    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.dimple.apply_preset(preset="object_2_vinyl_air")
    obj = bpy.context.object
    obj.dimple.simulated = "MESH"
    return Body.from_object(obj).session


def outward(mesh: Any) -> np.ndarray:
    """Return the normal (n, 3) at each vertex."""
    a, b, c = mesh.rest_positions[mesh.triangles].transpose(1, 0, 2)
    normals = np.zeros_like(mesh.rest_positions)
    for corner in mesh.triangles.T:
        np.add.at(normals, corner, np.cross(b - a, c - a))
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


@pytest.mark.parametrize("depth", [pytest.param(0.005, marks=pytest.mark.once), 0.020])
def test_a_pressed_suzanne_comes_back_wherever_she_is_pressed(monkey: Any, depth: float) -> None:
    from bl_ext.user_default.dimple.core.session import Finger

    mesh, model = monkey.model.mesh, monkey.model
    assert 500 <= len(mesh.rest_positions) <= 510
    normals, rng, law = outward(mesh), np.random.default_rng(0), model.materials[0].law
    for vertex in rng.choice(np.flatnonzero(~model.pinned & ~mesh.loose), PLACES, replace=False):
        monkey.reset()
        for down, seconds in ((-0.005, 0.01), (depth, 0.25), (depth, 0.2)):
            centre = mesh.rest_positions[vertex] + (RADIUS - down) * normals[vertex]
            monkey.set_fingers([Finger(tuple(centre.tolist()), RADIUS)])
            frame = monkey.step(seconds)
        assert frame.finite and frame.depths[0] > 0  # beside an eye it is as deep as it is in another part
        assert frame.pushes[0] == pytest.approx(law(float(frame.depths[0])), rel=1e-3)
        monkey.set_fingers([])
        monkey.step(1.0)
        assert np.abs(monkey.body.positions() - mesh.rest_positions.T).max() < LEFT, vertex
