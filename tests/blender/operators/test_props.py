"""A prop falls on a soft body in the viewport, rests in it, and is put back exactly."""

from types import ModuleType
from typing import Any

import numpy as np
import pytest

DROP = 0.05  # [scene units] above the cube, which stands for one of 165 mm and is 2 wide


@pytest.fixture
def weight(bpy: ModuleType, vinyl: Any, cube: Any) -> Any:
    """A flat weight of 1 kg above the vinyl cube; the cube is selected."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=16, radius=0.5, depth=0.2, location=(0.0, 0.0, 1.1 + DROP))
    prop = bpy.context.object
    prop.name = "Weight"
    prop.dimple.collider = prop.dimple.is_prop = True
    prop.select_set(False)
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    return prop


def curves_of(obj: Any) -> Any:
    return obj.animation_data.action.layers[0].strips[0].channelbag(obj.animation_data.action_slot).fcurves


def advance(bpy: ModuleType, seconds: float) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    for _ in range(round(30 * seconds)):
        assert live_step.advance(bpy.context, 1 / 30) == []


def test_it_falls_dents_the_body_and_is_put_back_bit_for_bit(
    bpy: ModuleType, sessions: Any, weight: Any, cube: Any
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    before = np.array(weight.matrix_basis)
    live_step.start_all(bpy.context)
    advance(bpy, 2.0)
    (body,) = sessions.sessions.values()
    skin, mesh = body.session.skin(), body.session.model.mesh
    middle = np.linalg.norm(mesh.rest_positions - (0.0, 0.0, 0.0825), axis=1).argmin()  # of the top
    assert skin[middle, 2] < 0.0825 - 5e-4, "it has dented the body"
    gap = 0.0825 * (weight.matrix_world.translation.z - 0.1) - skin[middle, 2]
    assert abs(gap) < 0.06 * mesh.rest_lengths.mean(), "and stands on it, thin as it is for so coarse a mesh"
    sessions.stop_all()
    np.testing.assert_array_equal(np.array(weight.matrix_basis), before)


def test_a_heavier_one_sinks_deeper_and_its_mass_can_be_changed_while_it_rests(
    bpy: ModuleType, sessions: Any, weight: Any
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    weight.dimple.prop_mass_kg = 0.3
    live_step.start_all(bpy.context)
    advance(bpy, 0.6)
    light = weight.matrix_world.translation.z
    weight.dimple.prop_mass_kg = 2.0
    advance(bpy, 0.6)
    assert weight.matrix_world.translation.z < light - 0.02
    sessions.stop_all()


def test_a_prop_without_a_mass_is_refused_in_words(bpy: ModuleType, sessions: Any, weight: Any) -> None:
    from bl_ext.user_default.dimple.core.errors import DimpleError
    from bl_ext.user_default.dimple.operators.press import live_step

    weight.dimple.prop_mass_kg = 0.0
    with pytest.raises(DimpleError, match="greater than 0 kg"):
        live_step.start_all(bpy.context)
    sessions.stop_all()


def test_a_bake_keyframes_where_it_falls(bpy: ModuleType, sessions: Any, weight: Any, tmp_path: Any) -> None:
    bpy.context.scene.dimple.cache_dir = str(tmp_path)
    weight.keyframe_insert("scale", frame=1)
    weight.keyframe_insert("location", frame=40)
    start = weight.matrix_world.translation.z
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=12) == {"FINISHED"}
    heights = []
    for frame in (1, 6, 12):
        bpy.context.scene.frame_set(frame)
        heights.append(weight.matrix_world.translation.z)
    kept = {curve.data_path: len(curve.keyframe_points) for curve in curves_of(weight)}
    assert kept == {"scale": 1, "location": 12, "rotation_euler": 12}, "its other keyframes stay"
    assert heights[0] == pytest.approx(start) and heights[1] < start - 0.01 and heights[2] < heights[0] - DROP / 2


def test_beside_the_body_it_lands_on_the_ground(bpy: ModuleType, sessions: Any, weight: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    bpy.context.scene.dimple.use_ground = True
    weight.location = 3.0, 0.0, 0.5
    bpy.context.view_layer.update()
    live_step.start_all(bpy.context)
    advance(bpy, 1.0)
    assert weight.matrix_world.translation.z == pytest.approx(0.1, abs=0.01), "half its height above the ground"
    sessions.stop_all()


def test_on_a_table_and_a_keyframed_tray_a_bake_is_what_was_live(
    bpy: ModuleType, sessions: Any, weight: Any, cube: Any, tmp_path: Any
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    scene = bpy.context.scene
    scene.dimple.cache_dir = str(tmp_path)
    weight.location = 4.0, 0.0, 0.3
    bpy.ops.mesh.primitive_plane_add(size=2.0, location=(4.0, 0.0, 0.0))
    tray = bpy.context.object
    tray.dimple.collider = True
    for frame, height in ((1, 0.0), (8, 0.0), (14, 0.3)):
        tray.location.z = height
        tray.keyframe_insert("location", frame=frame)
    tray.select_set(False)
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    scene.frame_set(1)
    live_step.start_all(bpy.context)
    heights = [weight.matrix_world.translation.z]
    for frame in range(2, 15):
        scene.frame_set(frame)
        assert live_step.advance(bpy.context, 1 / scene.render.fps) == []
        heights.append(weight.matrix_world.translation.z)
    sessions.stop_all()
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=14) == {"FINISHED"}
    baked = []
    for frame in range(1, 15):
        scene.frame_set(frame)
        baked.append(weight.matrix_world.translation.z)
    assert baked == pytest.approx(heights, abs=1e-6)
    assert min(heights) == pytest.approx(0.1, abs=0.01), "half its height above the tray"
    assert heights[-1] > 0.35, "which lifts it"
