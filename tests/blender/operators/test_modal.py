"""The poke fed with events by hand: Blender without a window runs none, so what it would call is called."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Bits = Callable[[Any], bytes]
RADIUS_PX = 200  # see conftest.py


@pytest.fixture(autouse=True)
def body(ball: Callable[..., Any]) -> Any:
    """The ball that is there."""
    return ball()


def ball_of(bpy: ModuleType) -> Any:
    return bpy.data.objects["Ball"]


def test_press_hold_release_and_escape(
    bpy: ModuleType, hand: Any, rest: bytes, coordinates: Bits, shown: Any
) -> None:
    poke = hand("poke")
    assert poke.invoke() == {"RUNNING_MODAL"}
    assert poke.context.said.startswith("Left drag")
    poke.ticks(3)
    assert coordinates(ball_of(bpy)) == rest, "nothing moves before the press"
    assert poke.send("MOUSEMOVE", "NOTHING") == {"PASS_THROUGH"}
    assert poke.send("LEFTMOUSE") == {"RUNNING_MODAL"}
    poke.ticks(20)
    from bl_ext.user_default.dimple.operators.press import sessions

    body = sessions.get(ball_of(bpy))
    assert body.frame.depths[0] == pytest.approx(0.015, abs=1e-3) and np.linalg.norm(body.frame.finger_forces[0]) > 1
    assert shown(ball_of(bpy))[:, 2].max() < 0.95
    assert poke.send("LEFTMOUSE", "RELEASE") == {"RUNNING_MODAL"}
    poke.ticks(40)
    assert body.fingers[0] is None, "it is off; a circle under the mouse shows where it would press"
    assert not body.frame.depths.any()
    assert poke.send("ESC") == {"CANCELLED"}
    assert coordinates(ball_of(bpy)) == rest
    assert not ball_of(bpy).modifiers and not bpy.data.node_groups


def test_enter_keeps_and_one_undo_restores(bpy: ModuleType, hand: Any, rest: bytes, coordinates: Bits) -> None:
    bpy.ops.ed.undo_push(message="Before")
    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(20)
    assert poke.send("RET") == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Poke")  # what Blender does for FINISHED
    assert coordinates(ball_of(bpy)) == rest and "Pressed" in ball_of(bpy).modifiers
    bpy.ops.ed.undo()
    assert coordinates(ball_of(bpy)) == rest and not ball_of(bpy).modifiers


def test_a_stroke_leaves_no_undo_step_for_it_has_changed_nothing(
    bpy: ModuleType, hand: Any, rest: bytes, coordinates: Bits
) -> None:
    bpy.ops.ed.undo_push(message="Before")
    ball_of(bpy).location.x = 1.0
    bpy.ops.ed.undo_push(message="The artist's own move")
    ball_of(bpy).location.x = 0.0
    bpy.ops.ed.undo_push(message="And another")
    poke = hand("poke")
    poke.invoke()
    for _ in range(2):
        poke.send("LEFTMOUSE")
        poke.ticks(20)
        poke.send("LEFTMOUSE", "RELEASE")
        poke.ticks(20)
    poke.send("ESC")
    bpy.ops.ed.undo()
    assert ball_of(bpy).location.x == 1.0 and coordinates(ball_of(bpy)) == rest


def test_keys_do_what_the_status_bar_says(bpy: ModuleType, hand: Any, rest: bytes, tmp_path: Path) -> None:
    settings = bpy.context.scene.dimple
    settings.cache_dir, settings.finger_radius_mm = str(tmp_path), 10
    poke = hand("poke")
    poke.invoke()
    settings.press_by, settings.press_force_n = "FORCE", 5.5
    poke.ticks(1)
    assert "5.5 N" in poke.context.said and "Ctrl F: force" in poke.context.said
    settings.press_by, settings.press_depth_mm, settings.finger_radius_mm = "DEPTH", 12.0, 11.0
    poke.ticks(1)
    assert poke.operator._state.depth == pytest.approx(0.012) and poke.operator._state.radius == pytest.approx(0.011)
    assert "press 12 mm deep | F: radius 11 mm | Ctrl F: depth" in poke.context.said
    poke.send("TWO")
    assert settings.active_finger == 2
    poke.send("LEFTMOUSE")
    poke.ticks(3)
    from bl_ext.user_default.dimple.operators.press import sessions

    body = sessions.get(ball_of(bpy))
    assert body.fingers[0] is None and body.fingers[1] is not None
    poke.send("SPACE")
    paused = body.frame.time
    poke.ticks(3)
    assert body.frame.time == paused and not body.running
    assert "Space: go on" in poke.context.said
    poke.send("SPACE")
    poke.ticks(1)
    assert "Space: pause" in poke.context.said
    poke.send("ESC")


def test_a_pen_presses_as_deep_as_it_is_pressed(bpy: ModuleType, hand: Any, rest: bytes) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE", is_tablet=True, pressure=0.4)
    poke.ticks(20)
    assert sessions.get(ball_of(bpy)).frame.depths[0] == pytest.approx(0.4 * 0.015, abs=1e-3)
    poke.send("RIGHTMOUSE")


def test_undo_takes_a_constant_back_while_poking_but_nothing_from_before(
    bpy: ModuleType, hand: Any, rest: bytes
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    ball_of(bpy).active_material = bpy.data.materials.new("Tuned")
    bpy.ops.ed.undo_push(message="Before")
    poke = hand("poke")
    poke.invoke()
    poke.ticks(2)
    assert poke.send("Z", ctrl=True) == {"RUNNING_MODAL"}
    poke.send("TWO")  # no step of undo, but the next one goes back beyond it
    poke.ticks(2)
    ball_of(bpy).active_material.dimple.K1 = 3.0
    bpy.ops.ed.undo_push(message="K1")
    poke.ticks(2)
    body = sessions.get(ball_of(bpy))
    assert body.session.model.materials[0].K1 == 3000
    assert poke.send("Z", ctrl=True) == {"PASS_THROUGH"}
    bpy.ops.ed.undo()  # as Blender does then
    poke.ticks(2)
    assert body.session.model.materials[0].K1 == 610 and "Left drag" in poke.context.said
    assert poke.send("Z", ctrl=True) == {"RUNNING_MODAL"}
    poke.send("ESC")


def test_undo_is_swallowed_and_navigation_sizing_and_the_side_regions_are_not(
    bpy: ModuleType, hand: Any, rest: bytes
) -> None:
    poke = hand("poke")
    poke.invoke()
    swallowed = (
        ("Z", {"ctrl": True}), ("Z", {"oskey": True}), ("X", {}), ("TAB", {}), ("G", {}), ("R", {}),
        ("N", {"ctrl": True}),
    )  # fmt: skip
    for kind, more in swallowed:
        assert poke.send(kind, **more) == {"RUNNING_MODAL"}, kind
    assert poke.send("Z", at=None, ctrl=True) == {"RUNNING_MODAL"}, "not even over the sidebar"
    for kind, more in (
        ("MIDDLEMOUSE", {}), ("NUMPAD_1", {}), ("NDOF_MOTION", {}), ("TRACKPADPAN", {}),
        ("WHEELUPMOUSE", {}), ("WHEELDOWNMOUSE", {"ctrl": True}), ("LEFTMOUSE", {"alt": True}), ("N", {}), ("T", {}),
        ("F", {}), ("F", {"ctrl": True}),
    ):  # fmt: skip
        assert poke.send(kind, **more) == {"PASS_THROUGH"}, kind
    for kind in ("LEFTMOUSE", "SPACE", "RIGHTMOUSE", "RET"):
        assert poke.send(kind, at=None) == {"PASS_THROUGH"}, "outside the viewport"
    assert poke.send("ESC", at=None) == {"CANCELLED"}


def test_a_3d_mouse_turns_the_view_while_a_fingertip_presses_and_the_press_stays(
    bpy: ModuleType, hand: Any, rest: bytes
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(20)
    body = sessions.get(ball_of(bpy))
    tip, depth = body.fingers[0], float(body.frame.depths[0])
    for kind in ("NDOF_MOTION", "NDOF_BUTTON_FIT", "NDOF_BUTTON_TOP"):
        for value in ("PRESS", "RELEASE", "NOTHING"):
            assert poke.send(kind, value) == {"PASS_THROUGH"}, (kind, value)
    poke.ticks(5)
    assert poke.send("F") == {"RUNNING_MODAL"}, "it would take the end of the stroke"
    assert body.fingers[0] == tip and body.frame.depths[0] == pytest.approx(depth, rel=0.02) and depth > 0.01
    assert poke.send("ESC") == {"CANCELLED"}


def test_a_click_beside_the_ball_is_blenders_which_selects(
    bpy: ModuleType, hand: Any, rest: bytes, coordinates: Bits
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    beside, poke = (500 + 2 * RADIUS_PX, 500), hand("poke")
    assert poke.invoke("LEFTMOUSE", "PRESS", beside) == {"PASS_THROUGH"} and not sessions.sessions, "nothing begins"
    poke.invoke()
    for value in ("PRESS", "RELEASE", "CLICK", "DOUBLE_CLICK"):
        assert poke.send("LEFTMOUSE", value, at=beside) == {"PASS_THROUGH"}, value
    poke.ticks(5)
    assert coordinates(ball_of(bpy)) == rest
    poke.send("ESC")


def test_the_tool_selects_the_soft_body_that_it_presses(bpy: ModuleType, hand: Any, body: Any, ball: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    other, poke = ball("Other"), hand("poke")
    other.location = (10.0, 0.0, 0.0)
    body.select_set(False)
    assert poke.invoke("LEFTMOUSE", "PRESS", (500, 500)) == {"PASS_THROUGH"}, "neither soft nor selected"
    body.dimple.enabled = True
    assert poke.invoke("LEFTMOUSE", "PRESS", (500, 500)) == {"RUNNING_MODAL"}
    assert list(sessions.sessions) == [body.session_uid] and bpy.context.object == body and not other.select_get()
    poke.send("ESC")


def test_fingertip_and_depth_follow_the_size_of_the_body_until_they_are_typed(bpy: ModuleType, hand: Any) -> None:
    settings, ball = bpy.context.scene.dimple, ball_of(bpy)
    assert settings.radius_follows and settings.depth_follows
    bpy.context.object.dimple.material = "pillow"
    assert (settings.finger_radius_mm, settings.press_depth_mm) == pytest.approx((36.36, 54.55), rel=1e-3)
    settings.press_depth_mm = 20.0
    assert settings.radius_follows and not settings.depth_follows
    ball.dimple.size_mm = 330.0
    poke = hand("poke")
    poke.invoke()
    assert (settings.finger_radius_mm, settings.press_depth_mm) == pytest.approx((20.0, 20.0))
    ball.dimple.size_mm = 82.5
    poke.ticks(3)
    assert poke.operator._state.radius == pytest.approx(0.005) and poke.operator._state.depth == pytest.approx(0.02)
    poke.send("ESC")
    settings.depth_follows = True
    assert settings.press_depth_mm == pytest.approx(7.5)
    settings.finger_1 = bpy.data.objects.new("Fingertip", None)
    bpy.context.object.dimple.material = "pillow"
    assert settings.finger_radius_mm == pytest.approx(5.0), "what is keyframed stays as large"


def test_a_drag_takes_the_dent_along(bpy: ModuleType, hand: Any, rest: bytes) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(10)
    for x in range(500, 561, 10):
        poke.send("MOUSEMOVE", "NOTHING", (x, 500))
        poke.ticks(2)
    poke.ticks(10)
    finger = sessions.get(ball_of(bpy)).fingers[0]
    # 60 px are 0.3 of the radius, and the sphere touches beside its centre
    assert finger.position[0] == pytest.approx(0.3 * 0.0825, abs=0.004)
    assert finger.position[2] < 0.0825
    poke.send("ESC")


def test_reset_from_the_sidebar_ends_the_poke(bpy: ModuleType, hand: Any, rest: bytes, coordinates: Bits) -> None:
    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(10)
    bpy.ops.dimple.reset()
    assert coordinates(ball_of(bpy)) == rest
    assert poke.ticks(1) == {"CANCELLED"}


def test_something_unforeseen_ends_the_poke_and_is_raised(
    bpy: ModuleType, hand: Any, rest: bytes, coordinates: Bits, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import modal_runs, sessions

    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE")
    poke.ticks(10)

    def broken(*_: Any, **__: Any) -> None:
        raise ZeroDivisionError("unforeseen")

    monkeypatch.setattr(sessions.get(ball_of(bpy)).session, "begin", broken)
    with pytest.raises(ZeroDivisionError):
        poke.ticks(1)
    assert coordinates(ball_of(bpy)) == rest and not modal_runs.runs


def test_a_soft_body_that_was_not_selected_joins_when_it_is_pressed(
    bpy: ModuleType, hand: Any, ball: Any, body: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    other = ball("Other")
    other.location = (10.0, 0.0, 0.0)
    other.select_set(False)
    body.select_set(True)
    bpy.context.view_layer.objects.active = body
    beside = (500 + 10 * RADIUS_PX, 500)
    poke = hand("poke")
    poke.invoke()
    poke.send("LEFTMOUSE", at=beside)
    assert len(sessions.sessions) == 1, "it is no soft body: Blender selects it"
    other.dimple.enabled = True
    poke.send("LEFTMOUSE", at=beside)
    poke.ticks(20)
    assert sessions.get(other).frame.depths[0] > 0.01
    poke.send("ESC")
