"""What lets the haptic device have force in Blender, and what takes it away: the dead-man key, and a body at once."""

import time
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.operators.device_rig import connect, connection, run, softened, strongest, under_device, wait
from tests.haptics.machine import NEEDS_PTY

pytestmark = NEEDS_PTY


def test_without_the_dead_man_switch_there_is_no_force(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    under_device(bpy, port, add)
    bpy.ops.dimple.arm_device(hold_s=0.0)
    until = time.perf_counter() + 1.0
    report = wait(lambda _: time.perf_counter() > until, bpy)
    assert report.arming.name == "WAITING" and strongest(report) == 0.0
    bpy.ops.dimple.disarm_device()
    assert wait(lambda report: report.arming.name == "OFF", bpy)


class Watch:
    """Follow the dead-man key as the operator does: events in, and whether the key counts as held out."""

    def __init__(self, bpy: ModuleType) -> None:
        from bl_ext.user_default.dimple.operators.device.connect_device import DIMPLE_OT_arm_device

        self.timers: list[float] = []
        names = ("invoke", "modal", "cancel", "_end", "_is_armed")
        self.operator = type("Stub", (), {name: DIMPLE_OT_arm_device.__dict__[name] for name in names})()
        manager = SimpleNamespace(
            modal_handler_add=lambda _: None,
            event_timer_add=lambda seconds, window: self.timers.append(seconds) or seconds,
            event_timer_remove=self.timers.remove,
        )
        workspace = SimpleNamespace(status_text_set=lambda _text: None)
        self.context = SimpleNamespace(window_manager=manager, workspace=workspace, window=None)
        assert self.operator.invoke(self.context, None) == {"RUNNING_MODAL"}

    def send(self, kind: str, value: str = "NOTHING", *, shift: bool = False) -> set[str]:
        return self.operator.modal(self.context, SimpleNamespace(type=kind, value=value, shift=shift))

    def press(self) -> None:
        self.send("LEFT_SHIFT", "PRESS")
        assert self.holds()
        self.send("TIMER", shift=True)
        assert self.holds()

    def holds(self) -> bool:
        return connection().device.held_until > time.perf_counter()


LOST = {
    "it is released": [("LEFT_SHIFT", "RELEASE", False)],
    "it is released while the other Shift is down": [("LEFT_SHIFT", "RELEASE", True), ("LEFT_SHIFT", "CLICK", True)],
    "it is released after a short while, which Blender calls a click too": [
        ("LEFT_SHIFT", "RELEASE", False), ("LEFT_SHIFT", "CLICK", False), ("TIMER", "NOTHING", False),
    ],
    "another operator kept its release to itself": [("TIMER", "NOTHING", False)],
    "another window is in front": [("WINDOW_DEACTIVATE", "NOTHING", True)],
    "another window is in front, and Blender does not know that it is up": [
        ("WINDOW_DEACTIVATE", "NOTHING", True), ("TIMER", "NOTHING", True), ("MOUSEMOVE", "NOTHING", True),
    ],
    "the mouse moves without it": [("MOUSEMOVE", "NOTHING", False)],
}  # fmt: skip


def test_the_key_is_let_go_when(bpy: ModuleType, port: Any) -> None:
    connect(bpy, port.path)
    for how, events in LOST.items():
        watch = Watch(bpy)
        watch.send("TIMER", shift=True)
        assert not watch.holds(), f"a key that was down before is not this one; then {how}"
        for _ in range(2):
            watch.press()
            for kind, value, shift in events:
                watch.send(kind, value, shift=shift)
                assert not watch.holds(), how


def test_the_key_is_let_go_when_it_is_not_renewed(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    """The operator is gone, or Blender stands still; that frames go on holds nothing."""
    from bl_ext.user_default.dimple.core.device.limits import LEASE
    from bl_ext.user_default.dimple.operators.press import live_step

    connect(bpy, port.path)
    run(bpy, add())
    watch = Watch(bpy)
    watch.press()
    pressed = time.perf_counter()
    live_step.advance(bpy.context, 1 / 60)
    assert connection().device._order.held_until <= pressed + LEASE
    time.sleep(LEASE)
    live_step.advance(bpy.context, 1 / 60)
    assert not watch.holds() and not connection().device._order.is_held(time.perf_counter())


def test_only_a_timer_and_the_key_itself_are_told_to_the_servo(bpy: ModuleType, port: Any) -> None:
    """Each order is a message, and a mouse moves a thousand times a second."""
    connect(bpy, port.path)
    watch = Watch(bpy)
    watch.press()
    before = connection().device._order
    watch.send("MOUSEMOVE", shift=True)
    assert connection().device._order is before and watch.holds()
    watch.send("TIMER", shift=True)
    assert connection().device._order.held_until > before.held_until


def test_the_newest_operator_follows_the_key_alone(
    bpy: ModuleType, port: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import modal_runs

    cleared: list[bool] = []  # a stub's workspace is not among Blender's
    monkeypatch.setattr(modal_runs, "clear_status", lambda: cleared.append(True))
    connect(bpy, port.path)
    old, new = Watch(bpy), Watch(bpy)
    assert old.send("LEFT_SHIFT", "PRESS") == {"FINISHED"} and not old.holds() and not old.timers
    new.press()
    newest = Watch(bpy)
    newest.press()
    assert new.send("TIMER") == {"FINISHED"} and not new.timers and newest.holds() and not cleared
    assert bpy.ops.dimple.arm_device(hold_s=60.0) == {"FINISHED"}
    assert newest.send("TIMER", shift=True) == {"FINISHED"} and not newest.timers
    assert newest.holds() and cleared, "the script holds it, and no key does"


def test_escape_disarms(bpy: ModuleType, port: Any) -> None:
    connect(bpy, port.path)
    watch = Watch(bpy)
    watch.press()
    wait(lambda report: report.arming.name == "ON", arms=True)
    watch = Watch(bpy)
    watch.press()
    assert watch.send("ESC", "PRESS") == {"FINISHED"} and not watch.holds() and not watch.timers
    wait(lambda report: report.arming.name == "OFF")


ENDS = ("poke", "play")


@pytest.mark.parametrize("name", ENDS)
def test_escape_of_whatever_runs_disarms(
    bpy: ModuleType, port: Any, add: Callable[..., Any], hand: Any, name: str
) -> None:
    softened(bpy, add())
    connect(bpy, port.path)
    runs = hand(name)
    assert runs.invoke() == {"RUNNING_MODAL"}
    wait(lambda report: report.arming.name == "ON", arms=True)
    if name == "poke":
        assert runs.send("LEFT_SHIFT", shift=True) == {"PASS_THROUGH"}, "it passes the dead-man key on"
    assert runs.send("ESC") == {"CANCELLED"}
    wait(lambda report: report.arming.name == "OFF")


def test_reset_disarms(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    connect(bpy, port.path)
    run(bpy, add())
    wait(lambda report: report.arming.name == "ON", arms=True)
    assert bpy.ops.dimple.reset() == {"FINISHED"}
    wait(lambda report: report.arming.name == "OFF")


@pytest.mark.parametrize(("above", "kicks"), [pytest.param(0.040, False, marks=pytest.mark.once), (-0.040, True)])
def test_a_body_put_under_the_fingertips_at_once_disarms(
    bpy: ModuleType, port: Any, add: Callable[..., Any], above: float, kicks: bool
) -> None:
    """They are in it when its session starts, and nothing may kick; below them, it may start."""
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    body, notes = add(), []
    connect(bpy, port.path)
    for _ in range(3 if kicks else 1):  # a busy machine may have disarmed it meanwhile
        wait(lambda report: report.arming.name == "ON", arms=True)
        entry = run(bpy, body)
        bpy.context.scene.dimple.device_origin[2] += above / entry.link.scale
        notes += live_step.advance(bpy.context, 1 / 60) + live_step.advance(bpy.context, 1 / 60)
        if kicks:
            wait(lambda report: report.arming.name == "OFF")
        sessions.stop_all()
    assert any("has changed" in sentence for sentence in notes) == kicks


def painted(body: Any, map_name: str, value: float) -> None:
    """Give a body a map with one value everywhere."""
    body.vertex_groups.new(name="Painted").add(range(len(body.data.vertices)), value, "REPLACE")
    setattr(body.dimple, f"{map_name}_group", "Painted")


@pytest.mark.parametrize("what", ["place", "material", "softness", pytest.param("radius", marks=pytest.mark.once)])
def test_another_place_or_radius_or_a_stiffer_law_disarms_while_a_fingertip_presses(
    bpy: ModuleType, port: Any, add: Callable[..., Any], what: str
) -> None:
    """As when a step that set it is undone, the wheel turns, or one paints: the wall would jump by as much."""
    from bl_ext.user_default.dimple.operators.press import live_step

    body = under_device(bpy, port, add).obj
    notes, settings = [], bpy.context.scene.dimple
    for _ in range(3):  # a busy machine may have disarmed it meanwhile
        wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
        if what == "place":
            settings.device_origin[2] -= 0.1
        elif what == "material":
            bpy.data.materials["Soft"].dimple.K1 *= 4.0
        elif what == "softness":
            painted(body, what, 0.0)  # four times stiffer
        else:
            settings.finger_radius_mm += 2.0
        notes += live_step.advance(bpy.context, 1 / 60) + live_step.advance(bpy.context, 1 / 60)
        wait(lambda report: report.arming.name == "OFF", bpy)
        if any("has changed" in sentence for sentence in notes):
            return
    raise AssertionError(notes)


class PlacedDevice:
    """An armed device with one fingertip, where the test puts it; it counts how often it is disarmed."""

    def __init__(self) -> None:
        self.place, self.disarmed = (0.0, 0.0, 0.0), 0

    def read(self) -> Any:
        from bl_ext.user_default.dimple.core.device.force_guard import Arming
        from bl_ext.user_default.dimple.core.device.orders import LinkState, ServoReport, TipState

        tip = TipState(self.place, (0.0, 0.0, 0.0), 0.0, False, False)
        return ServoReport(link=LinkState.READY, arming=Arming.ON, tips=(tip,))

    def write(self, _surfaces: Any) -> None:
        pass

    def disarm(self) -> None:
        self.disarmed += 1

    def close(self) -> None:
        pass


@pytest.mark.parametrize("pressed_mm", [5.0, 15.0])
@pytest.mark.parametrize(
    ("painting", "weight", "disarms"),
    [
        ("softness", 0.5, False), ("softness", 1.0, False), ("softness", 0.49, False), ("softness", 0.3, True),
        ("softness", 0.0, True), ("knee", 0.5, False), ("knee", 0.05, True),
    ],
)  # fmt: skip
def test_it_is_the_stiffer_law_that_disarms_and_not_the_hand_that_presses_while_one_paints(
    bpy: ModuleType, add: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, painting: str, weight: float,
    disarms: bool, pressed_mm: float,
) -> None:  # fmt: skip
    """From 5 mm, or 1 N, in one frame. A softness of 0.49 is 3 % stiffer, by 0.03 N; a knee of 0.05 lies at 3 mm."""
    from bl_ext.user_default.dimple.operators.press import follow_settings, haptic_fingertips, live_step, sessions

    monkeypatch.setattr(follow_settings, "PAINTED_S", 0.0)  # each frame reads what is painted
    body, device = add(), PlacedDevice()
    softened(bpy, body)
    painted(body, painting, 0.5)
    run(bpy, body)
    haptic_fingertips.connections.append(haptic_fingertips.Connection(device=device, report=device.read()))
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    try:
        for z in (0.020, 0.0, -0.005):
            device.place = (0.0, 0.0, z)
            live_step.advance(bpy.context, 1 / 60)
        assert not device.disarmed
        device.place = (0.0, 0.0, -pressed_mm / 1e3)
        bpy.context.object.vertex_groups["Painted"].add(range(len(body.data.vertices)), weight, "REPLACE")
        before = sessions.get(body).session.model
        notes = live_step.advance(bpy.context, 1 / 60)
        notes += live_step.advance(bpy.context, 1 / 60)
        assert sessions.get(body).session.model is not before, "the paint was read"
        assert bool(device.disarmed) == any("has changed" in sentence for sentence in notes) == disarms
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
        haptic_fingertips.disconnect()
        sessions.stop_all()


@pytest.mark.parametrize("how", ["undo", "blow-up"])
def test_a_body_that_is_somewhere_else_at_once_disarms(
    bpy: ModuleType, port: Any, add: Callable[..., Any], how: str
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    body = add()
    bpy.ops.ed.undo_push(message="Before")
    connect(bpy, port.path)
    entry = run(bpy, body)
    bpy.ops.ed.undo_push(message="After")
    before = connection().device._order.disarm
    wait(lambda report: report.arming.name == "ON", bpy, arms=True)
    if how == "undo":
        assert bpy.ops.ed.undo() == {"FINISHED"}
    else:
        rest = entry.session.body.positions()
        entry.session.body.set_state(rest, 1e30 * rest)
        assert any("diverged" in sentence for sentence in live_step.advance(bpy.context, 1 / 60))
    assert connection().device._order.disarm == before + 1
    wait(lambda report: report.arming.name == "OFF")


def test_a_pause_lets_the_key_go_though_it_is_held(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    """Nothing steps the sessions: the wall fades, the fingertip sinks in, and when it goes on nothing may push it."""
    under_device(bpy, port, add)
    wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
    report = wait(lambda report: report.arming.name in ("WAITING", "OFF"))
    assert strongest(report) == 0.0 and connection().device.held_until > time.perf_counter()


def test_a_new_session_remembers_nothing_of_the_last_one(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    body, last = add(), None
    connect(bpy, port.path)
    for _ in range(2):
        entry = run(bpy, body)
        live_step.advance(bpy.context, 1 / 60)
        assert entry is not last and {known for known, *_ in connection().known} == {entry}
        last = entry
        sessions.stop_all()


def test_what_the_mouse_presses_is_not_rendered_by_the_device(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    """The mouse takes the first fingertip: the device's presses nothing and has no force until the mouse lets go."""
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import live_step

    entry = under_device(bpy, port, add)
    live_step.advance(bpy.context, 1 / 60)
    mouse = Finger((0.0, 0.0, entry.link.scale + 0.010 - 0.012), 0.010)
    for _ in range(3):
        live_step.advance(bpy.context, 1 / 60, pressed={entry.link.uid: (mouse,)})
        first, second, _ = connection().device._order.surfaces
        assert first is None and second and entry.frame.depths[0] == pytest.approx(0.012, abs=1e-4)
    live_step.advance(bpy.context, 1 / 60)
    here, there = connection().device._order.surfaces[0], connection().report.tips[0].position
    assert here.depth(there) == pytest.approx(entry.frame.touches[0].depth, abs=1e-4) and entry.frame.depths[0] == 0.0


def test_a_mouse_that_lets_a_pressed_fingertip_go_disarms(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    """The device's own is inside the body, and would be pushed out at once."""
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import live_step

    entry, notes = under_device(bpy, port, add), []
    above = Finger((0.0, 0.0, entry.link.scale + 0.050), 0.010)
    for _ in range(3):  # a busy machine may have disarmed it meanwhile
        wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
        for _ in range(90):  # until the dent has come back
            live_step.advance(bpy.context, 1 / 60, pressed={entry.link.uid: (above,)})
        notes += live_step.advance(bpy.context, 1 / 60) + live_step.advance(bpy.context, 1 / 60)
        wait(lambda report: report.arming.name == "OFF", bpy)
        if notes:
            break
    assert any("has changed" in sentence for sentence in notes)
