"""Fingertips to animate: added and selected alone, clicked with the tool, and made of a press by hand."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_bake import table

Add = Callable[..., Any]
FPS = 25  # a frame is two ticks of the hand
M = 2 / 0.165  # scene units of a real metre of the ball
NEAR_MM = 0.5  # that a baked surface may be from what was seen


@pytest.fixture
def soft(bpy: ModuleType, scene: Any, ball: Add) -> Any:
    """A ball that a fingertip of 10 mm presses as it is; the scene shows 25 frames a second."""
    scene.render.fps = FPS
    obj = ball("Ball", 4)
    obj.dimple.enabled = True
    return obj


def curves(tip: Any) -> dict[tuple[str, int], list[tuple[float, float]]]:
    """Return the keyframes of an object by path and axis; all of them are linear."""
    found = {}
    for layer in tip.animation_data.action.layers:
        for curve in layer.strips[0].channelbag(tip.animation_data.action_slot).fcurves:
            assert {point.interpolation for point in curve.keyframe_points} == {"LINEAR"}
            found[curve.data_path, curve.array_index] = [tuple(point.co) for point in curve.keyframe_points]
    return found


def test_a_fingertip_is_added_on_the_top_and_selected_alone(bpy: ModuleType, scene: Any, soft: Any) -> None:
    assert bpy.ops.dimple.add_fingertip() == {"FINISHED"}
    tip = scene.dimple.finger_1
    assert bpy.context.object == tip and bpy.context.selected_objects == [tip] and tip.dimple.presses == soft
    assert tip.empty_display_size == pytest.approx(0.01 * M)
    assert tuple(tip.location) == pytest.approx((0, 0, 1 + 0.01 * M), abs=1e-5)
    assert bpy.ops.dimple.add_fingertip() == {"FINISHED"}, "another on the same body, from the first"
    assert scene.dimple.finger_2.dimple.presses == soft
    bpy.ops.dimple.add_fingertip()
    with pytest.raises(RuntimeError, match="three fingertips are in use"):
        bpy.ops.dimple.add_fingertip()


def test_a_fingertip_is_added_at_the_cursor_straight_out_of_the_surface(
    bpy: ModuleType, scene: Any, soft: Any
) -> None:
    soft.location, soft.rotation_euler = (3, 0, 0), (0.3, 0.2, 0.1)
    scene.cursor.location = (2, 0, 0)
    bpy.context.view_layer.update()
    bpy.ops.dimple.add_fingertip()
    tip = scene.dimple.finger_1
    bpy.context.view_layer.update()
    assert tuple(tip.location) == pytest.approx((2 - 0.01 * M, 0, 0), abs=0.02)
    outward = np.array(tip.matrix_world)[:3, 2]
    assert outward == pytest.approx((-1, 0, 0), abs=0.05), "its own Z axis is where it comes off"


def test_the_sphere_that_is_drawn_is_the_sphere_that_presses(bpy: ModuleType, scene: Any, soft: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    bpy.ops.dimple.add_fingertip()
    tip = scene.dimple.finger_1
    scene.dimple.finger_radius_mm = 25
    assert live_step.fingertips(scene, 1 / M)[0].radius == pytest.approx(0.01)
    tip.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    assert live_step.fingertips(scene, 1 / M)[0].radius == pytest.approx(0.02)
    tip.empty_display_type = "CUBE"
    assert live_step.fingertips(scene, 1 / M)[0].radius == pytest.approx(0.025), "no sphere is drawn: the tool's"


def test_bake_with_a_fingertip_active_bakes_the_body_that_it_presses(
    bpy: ModuleType, scene: Any, soft: Any, ball: Add
) -> None:
    other = ball("Other")
    other.location.x = 5
    bpy.context.view_layer.objects.active = soft
    bpy.ops.dimple.add_fingertip()
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=2) == {"FINISHED"}
    assert [each.name for each in soft.modifiers] == ["Dimple"] and not other.modifiers
    assert bpy.ops.dimple.unbake() == {"FINISHED"} and not soft.modifiers
    bpy.data.objects.remove(soft)
    with pytest.raises(RuntimeError, match="Only a fingertip is selected"):
        bpy.ops.dimple.bake(frame_start=1, frame_end=2)


def test_a_click_on_a_fingertip_selects_it_and_presses_nothing(
    bpy: ModuleType, scene: Any, soft: Any, hand: Any, sessions: Any, coordinates: Callable[[Any], bytes]
) -> None:
    before = coordinates(soft)
    bpy.ops.dimple.add_fingertip()
    tip = scene.dimple.finger_1
    tip.select_set(False)
    soft.select_set(True)
    bpy.context.view_layer.objects.active = soft
    poke = hand("poke")
    assert poke.invoke("LEFTMOUSE", "PRESS", (500, 500)) == {"CANCELLED"}
    assert bpy.context.selected_objects == [tip] and bpy.context.object == tip and not sessions.sessions
    poke = hand("poke")
    assert poke.invoke("LEFTMOUSE", "PRESS", (600, 500)) == {"RUNNING_MODAL"}, "beside it the body is pressed"
    assert list(sessions.sessions) == [soft.session_uid], "though the fingertip is selected"
    poke.ticks(3)
    poke.send("LEFTMOUSE", "RELEASE")
    assert poke.send("LEFTMOUSE") == {"CANCELLED"}, "while one pokes, too"
    assert coordinates(soft) == before and not soft.modifiers


def test_a_fingertip_behind_the_surface_is_not_in_the_way(
    bpy: ModuleType, scene: Any, soft: Any, hand: Any, sessions: Any
) -> None:
    bpy.ops.dimple.add_fingertip()
    scene.dimple.finger_1.location.z = -1.2
    bpy.context.view_layer.update()
    poke = hand("poke")
    assert poke.invoke("LEFTMOUSE", "PRESS", (500, 500)) == {"RUNNING_MODAL"}
    poke.send("ESC")


def shown_by_frame(bpy: ModuleType, poke: Any, obj: Any, shown: Any, seen: list[np.ndarray], ticks: int) -> None:
    for _ in range(ticks // 2):
        poke.ticks(2)
        seen.append(shown(obj).copy())


@pytest.mark.parametrize("by", ["depth", "force", "drag"])
def test_a_press_that_is_keyed_and_baked_moves_as_it_was_seen(
    bpy: ModuleType, scene: Any, soft: Any, hand: Any, sessions: Any, shown: Any, by: str
) -> None:
    scene.dimple.press_by, scene.dimple.press_force_n = ("FORCE" if by == "force" else "DEPTH"), 6.0
    scene.frame_set(7)
    poke = hand("poke")
    poke.invoke()
    poke.ticks(4)
    seen = [shown(soft).copy()]
    poke.send("LEFTMOUSE", at=(520, 500))
    shown_by_frame(bpy, poke, soft, shown, seen, 20)
    if by == "drag":
        for x in range(522, 560, 4):
            for each in (x, x + 2):
                poke.send("MOUSEMOVE", "NOTHING", at=(each, 500))
                poke.ticks(1)
            seen.append(shown(soft).copy())
    shown_by_frame(bpy, poke, soft, shown, seen, 10)
    poke.send("LEFTMOUSE", "RELEASE")
    shown_by_frame(bpy, poke, soft, shown, seen, 30)
    assert poke.send("ESC") == {"CANCELLED"}

    assert bpy.ops.dimple.key_press() == {"FINISHED"}
    tip = scene.dimple.finger_1
    assert bpy.context.object == tip and tip.dimple.presses == soft
    keyed = curves(tip)
    assert set(keyed) == {("location", 0), ("location", 1), ("location", 2)}
    frames = [at for at, _ in keyed["location", 2]]
    assert frames[0] == 7 and len(frames) < 0.8 * len(seen)
    assert bpy.ops.dimple.bake(frame_start=7, frame_end=6 + len(seen)) == {"FINISHED"}
    baked = []
    for frame in range(7, 7 + len(seen)):
        scene.frame_set(frame)
        baked.append(shown(soft).copy())
    off = np.array([np.linalg.norm(a - b, axis=1).max() for a, b in zip(baked, seen, strict=True)]) / M * 1e3
    deepest = max(np.linalg.norm(each - seen[0], axis=1).max() for each in seen) / M * 1e3
    assert deepest > 5 and off.max() < NEAR_MM


def test_a_pinch_becomes_two_fingertips_and_a_changed_radius_is_keyed(
    bpy: ModuleType, scene: Any, soft: Any, hand: Any, sessions: Any
) -> None:
    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE", at=(400, 500))
    poke.ticks(20)
    poke.send("TWO")
    poke.send("LEFTMOUSE", at=(600, 500))
    poke.ticks(10)
    scene.dimple.finger_radius_mm *= 1.1
    poke.ticks(10)
    assert bpy.ops.dimple.key_press() == {"FINISHED"}, "while it is under way"
    first, second = scene.dimple.finger_1, scene.dimple.finger_2
    assert set(bpy.context.selected_objects) == {first, second}
    assert ("scale", 0) not in curves(first)
    assert curves(second)["scale", 0][-1][1] == pytest.approx(1.1, rel=1e-3)
    assert not sessions.sessions, "its mouse and keys are free for the fingertips"
    with pytest.raises(RuntimeError, match="in use"):
        bpy.ops.dimple.key_press()


def test_a_press_by_device_is_from_where_it_touches_to_where_it_leaves(
    bpy: ModuleType, scene: Any, soft: Any, sessions: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.bridge import timeline
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips, live_step

    depths = [-10, -4, 2, 8, 9, 5, -3, -8]  # [mm]; it is in the air too
    top = 0.0825
    place = iter([Finger((0.0, 0.0, top + 0.01 - depth / 1e3), 0.01) for depth in depths])
    live_step.start_all(bpy.context)
    monkeypatch.setattr(haptic_fingertips, "fingertips", lambda *_: [next(place), None, None])
    monkeypatch.setattr(timeline, "is_playing", lambda _: True)
    for frame in range(20, 20 + len(depths)):
        scene.frame_set(frame)
        live_step.advance(bpy.context, 1 / FPS)
    sessions.stop_all()
    scene.frame_set(3)
    assert bpy.ops.dimple.key_press() == {"FINISHED"}
    keys = curves(scene.dimple.finger_1)["location", 2]
    assert (keys[0][0], keys[-1][0]) == (21, 26), "at the frames that the timeline showed, not at the current one"
    heights = [(height - 1) / M * 1e3 for _, height in keys]
    assert heights[0] == pytest.approx(10, abs=0.2) == heights[-1] and min(heights) == pytest.approx(1, abs=0.2)


def test_there_is_nothing_to_key_before_a_press_and_in_another_file(
    bpy: ModuleType, scene: Any, soft: Any, hand: Any, sessions: Any
) -> None:
    assert not bpy.ops.dimple.key_press.poll()
    bpy.ops.dimple.play(seconds=0.1)
    bpy.ops.dimple.reset()
    assert not bpy.ops.dimple.key_press.poll(), "no hand has pressed"
    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(3)
    poke.send("ESC")
    assert bpy.ops.dimple.key_press.poll()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert not bpy.ops.dimple.key_press.poll()


def test_keys_are_said_and_reach_beyond_the_scene_with_a_word(
    bpy: ModuleType, scene: Any, soft: Any, capfd: Any
) -> None:
    bpy.ops.dimple.poke(depth_mm=5, press_s=0.2, hold_s=0.2, release_s=0.2)
    scene.frame_end = 10
    bpy.ops.dimple.key_press()
    said = capfd.readouterr().out
    assert 'The press on "Ball" is keyframed from frame 1 to ' in said and "last frame of the scene, 10" in said


def test_a_press_from_a_script_is_keyed_and_baked_as_deep(bpy: ModuleType, scene: Any, soft: Any) -> None:
    scene.frame_set(1)
    bpy.ops.dimple.poke(depth_mm=10.0, press_s=0.1, hold_s=0.1, release_s=0.1)
    assert bpy.ops.dimple.key_press() == {"FINISHED"} and scene.dimple.finger_1
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=10) == {"FINISHED"}
    depths = [row["depth_1_mm"] for row in table(soft, scene)]
    assert max(depths) == pytest.approx(10.0, abs=0.5) and depths[-1] == pytest.approx(0, abs=1e-4)
