"""What poke and play share, fed with events by hand: they end when their body or window does, and time may lag."""

from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

Bits = Callable[[Any], bytes]


@pytest.fixture(autouse=True)
def body(ball: Callable[..., Any]) -> Any:
    """The ball that is there."""
    return ball()


@pytest.mark.parametrize("name", ["poke", "play"])
def test_deleting_the_body_ends_the_operator(bpy: ModuleType, hand: Any, body: Any, name: str) -> None:
    run = hand(name)
    run.invoke()
    run.ticks(3)
    bpy.data.objects.remove(body)
    assert run.ticks(2) == {"CANCELLED"}
    assert any("is gone" in text for _, text in run.reports)


@pytest.mark.parametrize("name", ["poke", "play", "bake"])
def test_loading_a_file_ends_the_operator(bpy: ModuleType, hand: Any, name: str) -> None:
    run = hand(name)
    run.invoke()
    run.ticks(2)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert run.ticks(1) == {"CANCELLED"}
    run.operator.cancel(run.context)


@pytest.mark.parametrize("name", ["poke", "play"])
def test_a_window_that_is_closed_ends_the_operator(
    bpy: ModuleType, hand: Any, body: Any, rest: bytes, coordinates: Bits, name: str, shown: Any
) -> None:
    bpy.context.scene.dimple.use_gravity = True
    run = hand(name)
    run.invoke()
    run.ticks(5)
    assert shown(body).tobytes() != rest
    run.operator.cancel(run.context)
    assert coordinates(body) == rest


def test_play_pauses_goes_on_and_ends(bpy: ModuleType, hand: Any, body: Any, rest: bytes, coordinates: Bits) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    bpy.context.scene.dimple.use_gravity = True
    play = hand("play")
    assert play.invoke() == {"RUNNING_MODAL"}
    assert play.ticks(5) == {"PASS_THROUGH"}
    entry, button = sessions.get(body), hand("play")
    assert entry.running and entry.frame.time > 0
    button.invoke()
    paused = entry.frame.time
    play.time += 1
    play.ticks(3)
    assert entry.frame.time == paused and not entry.running
    button.invoke()
    play.ticks(3)
    assert entry.running and entry.frame.time > paused
    for kind in ("Z", "MOUSEMOVE", "LEFTMOUSE", "TAB"):
        assert play.send(kind) == {"PASS_THROUGH"}
    assert play.send("ESC") == {"CANCELLED"}
    assert coordinates(body) == rest


def test_a_poke_takes_over_from_play(bpy: ModuleType, hand: Any, body: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    play, poke = hand("play"), None
    play.invoke()
    play.ticks(2)
    entry = sessions.get(body)
    poke = hand("poke")
    poke.invoke()
    assert play.operator.modal(play.context, play.event("TIMER")) == {"CANCELLED"}
    assert sessions.get(body) is entry, "the session goes on"
    poke.send("ESC")


def test_a_body_that_sleeps_is_not_shown_anew(
    bpy: ModuleType, ball: Callable[..., Any], body: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.bridge import press_modifier
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    shown, show = [], press_modifier.show
    monkeypatch.setattr(press_modifier, "show", lambda obj, offsets: shown.append(obj.name) or show(obj, offsets))
    other = ball("Other")
    for obj in (body, other):
        sessions.start(obj, bpy.context)
    try:
        for _ in range(50):
            live_step.advance(bpy.context, 0.02)
        shown.clear()
        live_step.advance(bpy.context, 0.02)
        assert shown == []
        entry = sessions.get(other)
        top = float(entry.session.positions()[:, 2].max())
        pressed = {entry.link.uid: [Finger((0.0, 0.0, top), 0.01)]}
        for _ in range(2):
            live_step.advance(bpy.context, 0.02, pressed=pressed)
        assert shown == [other.name, other.name]
        shown.clear()
        body.location.x += 1
        bpy.context.view_layer.update()
        live_step.advance(bpy.context, 0.02, pressed=pressed)
        assert shown == [body.name, other.name]
    finally:
        sessions.stop_all()


def test_a_slow_computer_slows_time_rather_than_tearing_the_skin(
    bpy: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step, modal_runs, sessions

    run = modal_runs.ModalRun(kind="play", timer=None)
    asked, budget = live_step.ask(bpy.context.scene, run, 5.0)
    assert asked == run.step_s and budget < 0.1
    body = SimpleNamespace(done=1e-3)
    monkeypatch.setattr(sessions, "sessions", {1: body})
    live_step.adapt(run, asked)
    assert run.step_s == pytest.approx(0.002)
    for _ in range(9):
        body.done = run.step_s
        live_step.adapt(run, asked)
    assert run.step_s == pytest.approx(0.1), "and is real again as soon as it can"


def test_bodies_that_play_together_have_one_clock(
    bpy: ModuleType, scene: Any, ball: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    for name in ("Slow", "Fast"):
        sessions.start(ball(name), bpy.context)
    slow, fast = sessions.sessions.values()
    begin = slow.session.begin
    monkeypatch.setattr(slow.session, "begin", lambda dt, **more: begin(min(dt, 0.003), **more))
    for _ in range(60):
        live_step.advance(bpy.context, 1 / 60)
    assert slow.frame.time == pytest.approx(60 * 0.003, abs=2e-3)
    assert fast.frame.time == pytest.approx(slow.frame.time, abs=1 / 60), "the fast one waits"
    sessions.stop_all()
