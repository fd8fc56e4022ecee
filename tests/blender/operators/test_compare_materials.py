"""Two materials are compared on twins that one press presses."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest

from tests.blender.operators.test_follow_settings import step


@pytest.fixture
def pair(bpy: ModuleType, sessions: Any, vinyl: Any, cube: Any) -> Any:
    """A vinyl cube and its twin, whose material is three times as hard."""
    assert bpy.ops.dimple.compare_materials() == {"FINISHED"}
    twin = bpy.data.objects["Cube B"]
    material = twin.active_material.dimple
    material.K1, material.K2 = 3 * material.K1, 3 * material.K2
    yield cube, twin
    sessions.stop_all()


def test_the_twin_stands_beside_with_a_material_of_its_own(bpy: ModuleType, pair: Any) -> None:
    cube, twin = pair
    gap = twin.matrix_world.translation - cube.matrix_world.translation
    assert gap.x == pytest.approx(2.5) and not gap.y and not gap.z
    assert twin.data != cube.data and twin.active_material != cube.active_material
    assert cube.active_material.dimple.K1 == pytest.approx(0.61), "that of the first is as it was"
    assert bpy.context.object == cube and not bpy.ops.dimple.compare_materials.poll()


@pytest.mark.parametrize("pressed", [0, 1])
def test_one_press_presses_both_in_the_same_place(bpy: ModuleType, sessions: Any, pair: Any, pressed: int) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import live_step

    bodies, _, wrong = live_step.start_all(bpy.context)
    assert len(bodies) == 2 and not wrong
    cube, twin = (sessions.get(obj) for obj in pair)
    body = (cube, twin)[pressed]
    x = 2.5 * body.link.scale * pressed
    for depth in (0.0, 0.008):
        finger = Finger((x, 0.0, body.link.scale + 0.01 - depth), 0.01)
        for _ in range(30):
            live_step.advance(bpy.context, 1 / 60, pressed={body.link.uid: (finger,)})
    assert cube.frame.depths[0] == pytest.approx(0.008, rel=1e-3)
    assert twin.frame.depths[0] == pytest.approx(0.008, rel=1e-3)
    assert twin.frame.pushes[0] == pytest.approx(3 * cube.frame.pushes[0], rel=1e-3)
    assert cube.frame.time == pytest.approx(twin.frame.time)


def test_by_force_the_softer_one_sinks_deeper(bpy: ModuleType, sessions: Any, pair: Any) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import live_step

    live_step.start_all(bpy.context)
    cube, twin = (sessions.get(obj) for obj in pair)
    finger = Finger((0.0, 0.0, cube.link.scale + 0.02), 0.02, 6.0)
    for _ in range(60):
        live_step.advance(bpy.context, 1 / 60, pressed={cube.link.uid: (finger,)})
    assert cube.frame.finger_forces[0][2] == pytest.approx(6.0, rel=0.01)
    assert twin.frame.finger_forces[0][2] == pytest.approx(6.0, rel=0.01)
    assert cube.frame.depths[0] > 1.5 * twin.frame.depths[0]


def test_a_fingertip_object_presses_the_twin_too(bpy: ModuleType, sessions: Any, pair: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    bpy.ops.dimple.add_fingertip()
    live_step.start_all(bpy.context)
    cube, twin = (sessions.get(obj) for obj in pair)
    tip = bpy.context.scene.dimple.finger_1
    tip.location.z -= 0.005 / cube.link.scale
    bpy.context.view_layer.update()
    for _ in range(6):
        live_step.advance(bpy.context, 1 / 60)
    assert cube.frame.depths[0] == pytest.approx(twin.frame.depths[0], rel=1e-3) and twin.frame.depths[0] > 0.004


@pytest.mark.parametrize("chosen", [0, 1])
def test_the_material_that_is_chosen_stays_and_the_twin_goes(
    bpy: ModuleType, sessions: Any, pair: Any, chosen: int, coordinates: Callable[[Any], bytes]
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    cube, rest = pair[0], coordinates(pair[0])
    live_step.start_all(bpy.context)
    bpy.context.view_layer.objects.active = pair[chosen]
    assert bpy.ops.dimple.use_material() == {"FINISHED"}
    assert [obj.name for obj in bpy.data.objects if obj.type == "MESH"] == ["Cube"] and len(bpy.data.meshes) == 1
    assert len(bpy.data.materials) == 1 and coordinates(cube) == rest and bpy.context.object == cube
    assert cube.active_material.dimple.K1 == pytest.approx((0.61, 1.83)[chosen])
    assert bpy.ops.dimple.compare_materials.poll() and not bpy.ops.dimple.use_material.poll()


def test_a_twin_whose_first_was_deleted_is_a_body_like_any_other(bpy: ModuleType, sessions: Any, pair: Any) -> None:
    bpy.data.objects.remove(pair[0])
    sessions.start(pair[1], bpy.context)
    assert step(bpy) == [] and not bpy.ops.dimple.use_material.poll()
