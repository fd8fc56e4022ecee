"""A body sways when it is led, follows a scale that grows, and a bake plays what was seen."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_rigs import bits, fingertip, skin, walker

Shown = Callable[[Any], np.ndarray]
Ball = Add = Callable[..., Any]


def jelly(obj: Any, **settings: Any) -> Any:
    """Give an object the softness of Ecoflex 00-10 and let it sway."""
    obj.dimple.enabled, obj.dimple.size_mode, obj.dimple.size_mm = True, "CUSTOM", 165.0
    for name, value in {"sway": 1.0, **settings}.items():
        setattr(obj.dimple, name, value)
    return obj


def baked_top(bpy: ModuleType, obj: Any, shown: Shown, last: int) -> np.ndarray:
    """Bake from frame 1 on and return where the highest vertex is in each frame (n, 3), in the scene."""
    scene = bpy.context.scene
    scene.frame_set(1)
    top = int(shown(obj)[:, 2].argmax())
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=last) == {"FINISHED"}
    path = []
    for frame in range(1, last + 1):
        scene.frame_set(frame)
        path.append(np.array(obj.matrix_world @ bpy_vector(bpy, shown(obj)[top])))
    return np.array(path)


def bpy_vector(bpy: ModuleType, at: np.ndarray) -> Any:
    from mathutils import Vector

    return Vector(at.tolist())


def test_a_ball_that_is_jerked_swings_at_the_frequency_of_its_first_mode(
    bpy: ModuleType, scene: Any, ball: Ball, shown: Shown, sessions: Any
) -> None:
    """Ecoflex of 165 mm, moved 40 mm in four frames."""
    obj = ball(subdivisions=3)
    bpy.context.view_layer.objects.active = obj
    bpy.context.object.dimple.material = "ecoflex_00_10"
    obj.dimple.size_mm, obj.dimple.sway_damping, size = 165.0, 0.05, 165.0 / max(obj.dimensions)
    hertz = sessions.start(obj, bpy.context)[0].session.sway_hz
    sessions.stop_all()
    for frame, x in ((5, 0.0), (9, 40.0 / size)):
        obj.location.x = x
        obj.keyframe_insert("location", frame=frame)
    path = size * baked_top(bpy, obj, shown, 72)[:, 0]
    swing = path[9:] - 40
    assert 10 < np.abs(swing).max() < 40  # mm
    power = np.abs(np.fft.rfft(swing * np.hanning(len(swing)), 4096))
    assert np.fft.rfftfreq(4096, 1 / 24)[power.argmax()] == pytest.approx(hertz, rel=0.1)
    assert hertz == pytest.approx(4.0, rel=0.1), "of finite elements on its lowest tenth: 3.85 Hz"


def test_a_body_that_grows_is_baked_as_it_grows(bpy: ModuleType, scene: Any, ball: Ball, shown: Shown) -> None:
    """Scale keyed 1 to 1.5 in 12 frames, as modelled; its base is pinned, or nothing is."""
    for pinned, sway in ((True, 0.0), (False, 0.0), (True, 1.0)):
        obj = ball(subdivisions=3)
        obj.dimple.enabled, obj.dimple.pinned, obj.dimple.sway = True, pinned, sway
        radius = max(obj.dimensions) / 2
        for frame, scale in ((1, 1.0), (12, 1.5)):
            obj.scale = (scale,) * 3
            obj.keyframe_insert("scale", frame=frame)
        bpy.context.scene.frame_set(1)
        end = baked_top(bpy, obj, shown, 16)[-1]
        assert end[2] == pytest.approx(1.5 * radius, rel=0.01), (pinned, sway)
        bpy.data.objects.remove(obj)


def test_a_parent_that_is_squashed_squashes_the_body(bpy: ModuleType, scene: Any, ball: Ball, shown: Shown) -> None:
    obj, parent = ball(subdivisions=3), bpy.data.objects.new("Parent", None)
    scene.collection.objects.link(parent)
    obj.parent, obj.dimple.enabled = parent, True
    height = obj.dimensions.z
    for frame, scale in ((1, 1.0), (12, 0.6)):
        parent.scale.z = scale
        parent.keyframe_insert("scale", frame=frame)
    scene.frame_set(1)
    baked_top(bpy, obj, shown, 24)
    scene.frame_set(24)
    world = np.array([obj.matrix_world @ bpy_vector(bpy, point) for point in shown(obj)])
    assert np.ptp(world[:, 2]) == pytest.approx(0.6 * height, rel=0.02)


def test_frame_rates_sway_alike(bpy: ModuleType, scene: Any, ball: Ball, shown: Shown) -> None:
    ends = []
    for fps in (24, 120):
        scene.render.fps = fps
        obj = jelly(ball(subdivisions=3), sway_hz=3.0)
        for second, x in ((0.0, 0.0), (1 / 6, 0.3)):
            obj.location.x = x
            obj.keyframe_insert("location", frame=1 + second * fps)
        for curve in curves(obj):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
        ends.append(baked_top(bpy, obj, shown, 1 + fps // 2)[-1])
        bpy.data.objects.remove(obj)
    assert np.abs(np.array(ends) - ends[0]).max() < 0.005 * 2


def test_a_keyframed_collider_pushes_the_sway_and_a_bake_equals_play(
    bpy: ModuleType, scene: Any, ball: Ball, add: Add, shown: Shown
) -> None:
    obj, hand, leans, last = jelly(ball(subdivisions=3), sway_hz=2.0), add(name="Hand"), [], None
    hand.dimple.collider, hand.scale = True, (0.2, 0.6, 0.3)
    hand.select_set(False)
    for frame, x in ((1, 1.25), (7, 0.9)):
        hand.location = (x, 0, 0.3)
        hand.keyframe_insert("location", frame=frame)
    for sway in (0.0, 1.0):
        obj.dimple.sway = sway
        last = baked_top(bpy, obj, shown, 13)[-1]
        leans.append(last[0])
    assert leans[1] < leans[0] - 0.05, leans
    bpy.ops.dimple.unbake()
    scene.frame_set(1)
    top = int(shown(obj)[:, 2].argmax())
    bpy.ops.dimple.play(frames=12)
    assert np.abs(np.array(obj.matrix_world @ bpy_vector(bpy, shown(obj)[top])) - last).max() < 1e-5
    bpy.ops.dimple.reset()


def test_what_can_be_driven_is_followed_and_what_is_read_once_cannot_be_driven(
    bpy: ModuleType, scene: Any, ball: Ball, shown: Shown
) -> None:
    obj = jelly(ball(subdivisions=3), sway_hz=3.0)
    for name in ("pin_group", "size_mode", "size_mm"):
        assert not obj.dimple.bl_rna.properties[name].is_animatable, name
        with pytest.raises(TypeError):
            obj.dimple.driver_add(name)
    obj.dimple.driver_add("sway").driver.expression = "1.0 if frame < 3 else 0.25"
    obj.location.x = 0.0
    for frame, x in ((4, 0.0), (8, 40.0 / (165.0 / max(obj.dimensions)))):
        obj.location.x = x
        obj.keyframe_insert("location", frame=frame)
    driven = baked_top(bpy, obj, shown, 24)[:, 0]
    obj.dimple.driver_remove("sway")
    obj.dimple.sway = 1.0
    whole = baked_top(bpy, obj, shown, 24)[:, 0]
    away, before = np.abs(driven[8:] - driven[8:].mean()).max(), np.abs(whole[8:] - whole[8:].mean()).max()
    assert away < 0.5 * before


def curves(obj: Any) -> Any:
    action = obj.animation_data.action
    if hasattr(action, "fcurves"):
        return action.fcurves
    return action.layers[0].strips[0].channelbags[0].fcurves


def test_what_nothing_holds_does_not_sway_and_says_so(bpy: ModuleType, scene: Any, ball: Ball, sessions: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions as running

    obj = jelly(ball(), pinned=False)
    bpy.context.view_layer.objects.active = obj
    _, said = running.start(obj, bpy.context)
    assert any("nothing holds it" in each for each in said)
    bpy.ops.dimple.reset()


@pytest.mark.parametrize("touched", [False, True])
def test_the_flesh_of_a_walker_sways_plays_as_baked_and_is_firm_where_its_weights_are(
    bpy: ModuleType, sessions: Any, scene: Any, add: Add, shown: Shown, touched: bool
) -> None:
    obj = walker(bpy, add)
    group = obj.vertex_groups.new(name="Bones")
    for vertex in obj.data.vertices:  # the shin is firm, the thigh free
        group.add([vertex.index], float(np.clip(2.0 - vertex.co.z, 0, 1)), "REPLACE")
    jelly(obj, pin_group="Bones", size_mm=400, sway_hz=4.0)
    if touched:
        place = skin(bpy, obj, 3 * 12)
        fingertip(bpy, scene, {frame: place(frame, 0.15 * min(max(frame - 2, 0), 2) / 2) for frame in range(1, 13)})
    scene.frame_set(1)
    live, before = [], bits(obj)
    for frame in range(1, 9):
        bpy.ops.dimple.play(frames=1)
        live.append((frame + 1, shown(obj), sessions.get(obj).rest.copy()))
    bpy.ops.dimple.reset()
    firm = np.array([vertex.co.z <= 1 for vertex in obj.data.vertices])
    away = np.linalg.norm(live[-1][1] - live[-1][2], axis=1)
    assert 0.002 < away[~firm].max() < 1.0, "the thigh sways"
    assert touched or away[firm].max() < 1e-5, "the shin does not"
    scene.frame_set(1)
    bpy.ops.dimple.bake(frame_start=1, frame_end=9)
    assert bits(obj) == before
    for frame, seen, _ in live:
        scene.frame_set(frame)
        assert np.abs(shown(obj) - seen).max() < 1e-6, "what is seen differs by the rounding of an offset"


def test_the_bones_of_a_rig_hold_flesh_that_nothing_is_pinned_of(
    bpy: ModuleType, sessions: Any, scene: Any, add: Add, shown: Shown
) -> None:
    obj = jelly(walker(bpy, add), pinned=False, size_mm=400)
    bpy.ops.dimple.play(frames=7)
    body = sessions.get(obj)
    assert len(body.link.bones) == 2 and body.session.sway_hz > 1
    away = np.linalg.norm(shown(obj) - body.rest, axis=1)
    assert 1e-3 < away.max() < 0.3
    bpy.ops.dimple.reset()
