"""The haptic device in Blender: an emulated one in a process of its own, behind a real pseudo-terminal."""

import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the emulator needs pseudo-terminals")
PATIENCE = 30.0  # [s] on a busy machine
AGAIN = 0.5  # [s] between two requests to arm
BEGIN = 1.2  # [s] from the device's ramp until the servo's is over
DOWN, UP = 4.0, 1.5  # [s] of a press and between two: a busy machine, disarmed for its gaps, arms again while it is up
WAY = [[0.0, 0.0, 0.0, 0.02]] + [
    [BEGIN + k * (DOWN + UP) + t, 0.0, 0.0, z]
    for k in range(12)
    for t, z in ((0.0, 0.02), (0.2, -0.010), (DOWN, -0.010), (DOWN + 0.2, 0.02))
]
APART = 0.02  # [m]


@pytest.fixture
def port(bpy: ModuleType, empty_file: ModuleType, tmp_path: Path) -> Iterator[Any]:
    """An emulator whose hand presses 10 mm deep once there is force; it ends with the test."""
    from bl_ext.user_default.dimple.core.devices.process import end, start
    from bl_ext.user_default.dimple.operators import haptic, sessions

    tips = [[[t, x + shift, y, z] for t, x, y, z in WAY] for shift in (-APART, 0.0, APART)]
    (tmp_path / "hand.json").write_text(json.dumps({"tips": tips}))
    path = tmp_path / "port"
    process = start(["emulator", "--pty", str(path), "--hand", str(tmp_path / "hand.json"), "--lifeline"], None)
    until = time.perf_counter() + PATIENCE
    while not os.path.exists(path) and time.perf_counter() < until:
        time.sleep(0.01)
    yield SimpleNamespace(path=str(path), process=process)
    haptic.disconnect()
    sessions.stop_all()
    end(process)


def connection() -> Any:
    from bl_ext.user_default.dimple.operators import haptic

    return haptic.get()


def wait(holds: Callable[[Any], bool], bpy: ModuleType | None = None, *, arms: bool = False) -> Any:
    """Let time pass until something holds of the report; with bpy, let the sessions run as Play does.

    arms: ask for force, again where the machine was too busy.
    """
    from bl_ext.user_default.dimple.operators import haptic, live

    until, asked = time.perf_counter() + PATIENCE, 0.0
    while not holds(connection().report):
        assert time.perf_counter() < until, connection().report
        if arms and connection().report.arming.name == "OFF" and time.perf_counter() - asked > AGAIN:
            asked = time.perf_counter()
            haptic.hold(60.0)
            connection().device.arm()
        if bpy:
            live.advance(bpy.context, 1 / 60)
        else:
            haptic._look()
        time.sleep(1 / 60)
    return connection().report


def connect(bpy: ModuleType, path: str) -> Any:
    bpy.context.scene.dimple.device_port = path
    assert bpy.ops.dimple.connect_device() == {"FINISHED"}
    return wait(lambda report: report.states > 10)


def run(bpy: ModuleType, body: Any) -> Any:
    """Start a session on a body under the fingertips: the middle of the workspace is where they touch its top."""
    from bl_ext.user_default.dimple.operators import live, sessions

    live.start_all(bpy.context)
    entry = sessions.get(body)
    bpy.context.scene.dimple.device_origin = (0.0, 0.0, 1.0 + 0.010 / entry.link.scale)
    return entry


def softened(bpy: ModuleType, body: Any) -> Any:
    """Give a body a material that any machine's delay lets a device render."""
    material = bpy.data.materials.new("Soft")
    body.data.materials.append(material)
    material.dimple.K1, material.dimple.K2, material.dimple.x0 = 0.2, 9.0, 30.0
    return material.dimple


def gone(pid: int) -> bool:
    for _ in range(300):
        status = Path(f"/proc/{pid}/stat")
        if not status.exists() or status.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.01)
    return False


def strongest(report: Any) -> float:
    return max(sum(c * c for c in tip.force) ** 0.5 for tip in report.tips)


def test_three_fingertips_press_the_session_and_feel_it(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    body = add()
    softened(bpy, body)
    connect(bpy, port.path)
    entry = run(bpy, body)
    assert bpy.ops.dimple.arm_device(hold_s=60.0) == {"FINISHED"}

    def felt(report: Any) -> bool:
        """All three rest at a depth, and feel 200 N/m of it."""
        depths = entry.frame.depths
        return (
            len(depths) == 3
            and depths.min() > 0.003
            and all(
                tip.force[2] == pytest.approx(200 * depth, rel=0.1)
                for tip, depth in zip(report.tips, depths, strict=True)
            )
        )

    wait(felt, bpy, arms=True)
    assert len([finger for finger in entry.fingers if finger]) == 3  # which the overlay draws


def test_without_the_dead_man_switch_there_is_no_force(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    body = add()
    softened(bpy, body)
    connect(bpy, port.path)
    run(bpy, body)
    bpy.ops.dimple.arm_device(hold_s=0.0)
    until = time.perf_counter() + 1.0
    report = wait(lambda _: time.perf_counter() > until, bpy)
    assert report.arming.name == "WAITING" and strongest(report) == 0.0
    bpy.ops.dimple.disarm_device()
    assert wait(lambda report: report.arming.name == "OFF", bpy)


class Watch:
    """Follow the dead-man key as the operator does: events in, and whether the key counts as held out."""

    def __init__(self, bpy: ModuleType) -> None:
        from bl_ext.user_default.dimple.operators.device import DIMPLE_OT_arm_device

        self.timers: list[float] = []
        names = ("invoke", "modal", "cancel", "_end", "_is_armed")
        self.operator = type("Stub", (), {name: DIMPLE_OT_arm_device.__dict__[name] for name in names})()
        manager = SimpleNamespace(
            modal_handler_add=lambda _: None,
            event_timer_add=lambda seconds, window: self.timers.append(seconds) or seconds,
            event_timer_remove=self.timers.remove,
        )
        workspace = SimpleNamespace(status_text_set=lambda _: None)
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
    "another operator kept its release to itself": [("TIMER", "NOTHING", False)],
    "another window is in front": [("WINDOW_DEACTIVATE", "NOTHING", True)],
    "another window is in front, and Blender does not know that it is up": [
        ("WINDOW_DEACTIVATE", "NOTHING", True), ("TIMER", "NOTHING", True), ("MOUSEMOVE", "NOTHING", True),
    ],
    "the mouse moves without it": [("MOUSEMOVE", "NOTHING", False)],
}  # fmt: skip


@pytest.mark.parametrize("how", LOST)
def test_the_key_is_let_go_when(bpy: ModuleType, port: Any, how: str) -> None:
    connect(bpy, port.path)
    watch = Watch(bpy)
    watch.send("TIMER", shift=True)
    assert not watch.holds(), "a key that was down before is not this one"
    for _ in range(2):
        watch.press()
        for kind, value, shift in LOST[how]:
            watch.send(kind, value, shift=shift)
            assert not watch.holds()


def test_the_key_is_let_go_when_nobody_looks_at_it_any_more(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    """The operator is gone, or Blender stands still; that frames go on holds nothing."""
    from bl_ext.user_default.dimple.core.devices.safety import LEASE
    from bl_ext.user_default.dimple.operators import live

    connect(bpy, port.path)
    run(bpy, add())
    watch = Watch(bpy)
    watch.press()
    pressed = time.perf_counter()
    live.advance(bpy.context, 1 / 60)
    assert connection().device._order.held_until <= pressed + LEASE
    time.sleep(LEASE)
    live.advance(bpy.context, 1 / 60)
    assert not watch.holds() and not connection().device._order.is_held(time.perf_counter())


def test_the_newest_operator_follows_the_key_alone(bpy: ModuleType, port: Any) -> None:
    connect(bpy, port.path)
    old, new = Watch(bpy), Watch(bpy)
    assert old.send("LEFT_SHIFT", "PRESS") == {"FINISHED"} and not old.holds() and not old.timers
    new.press()
    assert bpy.ops.dimple.arm_device(hold_s=60.0) == {"FINISHED"}
    assert new.send("TIMER", shift=True) == {"FINISHED"} and not new.timers


def test_escape_disarms(bpy: ModuleType, port: Any) -> None:
    connect(bpy, port.path)
    watch = Watch(bpy)
    watch.press()
    wait(lambda report: report.arming.name == "ON", arms=True)
    watch = Watch(bpy)
    watch.press()
    assert watch.send("ESC", "PRESS") == {"FINISHED"} and not watch.holds() and not watch.timers
    wait(lambda report: report.arming.name == "OFF")


ENDS = ("poke", "play", "compare_methods")


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
        assert runs.send("LEFT_SHIFT", shift=True) == {"PASS_THROUGH"}, "it keeps the dead-man key from nobody"
    assert runs.send("ESC") == {"CANCELLED"}
    wait(lambda report: report.arming.name == "OFF")


def test_reset_disarms(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    connect(bpy, port.path)
    run(bpy, add())
    wait(lambda report: report.arming.name == "ON", arms=True)
    assert bpy.ops.dimple.reset() == {"FINISHED"}
    wait(lambda report: report.arming.name == "OFF")


@pytest.mark.parametrize("who", ["servo", "emulator"])
def test_a_killed_process_takes_the_force_and_not_the_session(
    bpy: ModuleType, port: Any, add: Callable[..., Any], who: str
) -> None:
    from bl_ext.user_default.dimple.operators import live, sessions

    body = add()
    softened(bpy, body)
    connect(bpy, port.path)
    run(bpy, body)
    bpy.ops.dimple.arm_device(hold_s=60.0)
    wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
    servo = connection().device.process
    (servo if who == "servo" else port.process).send_signal(signal.SIGKILL)
    said: list[str] = []
    until = time.perf_counter() + PATIENCE
    while not said and time.perf_counter() < until:
        said += live.advance(bpy.context, 1 / 60)
        time.sleep(1 / 60)
    assert "onnect" in said[0]
    assert gone(servo.pid)
    before = sessions.get(body).frame.time
    assert live.advance(bpy.context, 1 / 60) == []
    assert sessions.get(body).frame.time > before
    assert not bpy.ops.dimple.arm_device.poll()


def test_the_panel_says_what_is_not_renderable(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    from bl_ext.user_default.dimple.addon import device

    settings = softened(bpy, add())
    report = connect(bpy, port.path)
    assert any("K2 is not renderable" in note for note in device.notes(report, settings))
    rows = dict(device.rows(report, settings))
    assert rows["K1 Asked, Felt"] == "0.20, 0.20 N/mm"
    asked, _, rendered = rows["K2 Asked, Felt"].partition(", ")
    assert (
        asked == "9.00"
        and float(rendered.split()[0]) == pytest.approx(report.cap / 1e3, abs=0.006)
        and report.cap < 1400
    )
    assert rows["State"] == "Ready, no force" and {"Rate", "Lost Frames", "Round Trip", "Force 1"} <= rows.keys()
    settings.K1 = 9.0
    assert any("K1 and K2" in note for note in device.notes(report, settings))
    assert any("more force than the device has" in note for note in device.notes(report, settings))


def test_the_origin_is_where_the_fingertips_are(bpy: ModuleType, port: Any) -> None:
    from bl_ext.user_default.dimple.operators import haptic

    connect(bpy, port.path)
    scene = bpy.context.scene
    scene.cursor.location = (1.0, 2.0, 3.0)
    scene.dimple.device_scale = 2.5
    assert bpy.ops.dimple.centre_device() == {"FINISHED"}
    tips = [tip.position for tip in connection().report.tips]
    middle = tuple(sum(tip[c] for tip in tips) / 3 for c in range(3))
    at = haptic.place(scene, 0.1).to_session(middle)
    assert at == pytest.approx((0.1, 0.2, 0.3), abs=1e-5)


@pytest.mark.parametrize(("above", "kicks"), [(0.040, False), (-0.040, True)])
def test_a_body_put_under_the_fingertips_at_once_disarms(
    bpy: ModuleType, port: Any, add: Callable[..., Any], above: float, kicks: bool
) -> None:
    """They are in it when its session starts, and nothing may kick; below them, it may start."""
    from bl_ext.user_default.dimple.operators import live, sessions

    body, said = add(), []
    connect(bpy, port.path)
    for _ in range(3 if kicks else 1):  # a busy machine may have disarmed it meanwhile
        wait(lambda report: report.arming.name == "ON", arms=True)
        entry = run(bpy, body)
        bpy.context.scene.dimple.device_origin[2] += above / entry.link.scale
        said += live.advance(bpy.context, 1 / 60) + live.advance(bpy.context, 1 / 60)
        if kicks:
            wait(lambda report: report.arming.name == "OFF")
        sessions.stop_all()
    assert any("has changed" in sentence for sentence in said) == kicks


def test_another_place_of_the_device_disarms_while_a_fingertip_presses(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    """As when a step that set it is undone: the wall would jump by as much."""
    body = add()
    softened(bpy, body)
    connect(bpy, port.path)
    run(bpy, body)
    wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
    bpy.context.scene.dimple.device_origin[2] -= 0.1
    wait(lambda report: report.arming.name == "OFF", bpy)


def test_a_new_session_remembers_nothing_of_what_was_felt_in_the_last(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    from bl_ext.user_default.dimple.operators import live, sessions

    body, felt = add(), []
    connect(bpy, port.path)
    for _ in range(2):
        entry = run(bpy, body)
        live.advance(bpy.context, 1 / 60)
        felt.append(connection().felt[entry])
        assert list(connection().felt) == [entry]
        sessions.stop_all()
    assert felt[0] is not felt[1]


@pytest.mark.parametrize("paused", [True, False], ids=["paused", "nothing runs"])
def test_a_servo_hears_of_blender_while_nothing_moves(
    bpy: ModuleType, port: Any, add: Callable[..., Any], paused: bool
) -> None:
    """Where its pipe cannot be watched (Windows) a servo that hears nothing for 10 s takes Blender for gone."""
    from bl_ext.user_default.dimple.core.devices.letters import ORDER_SIZE
    from bl_ext.user_default.dimple.core.devices.mailbox import TO_SERVO
    from bl_ext.user_default.dimple.operators import haptic

    body = add()
    connect(bpy, port.path)
    if paused:
        run(bpy, body)
    seen = 0
    for _ in range(3):
        time.sleep(haptic.LOOK_S)
        haptic._look()
        seen, order = connection().device._box.read(TO_SERVO, ORDER_SIZE, seen)
        assert order


def test_a_device_that_is_lost_while_play_is_paused_is_said_when_it_goes_on(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    from bl_ext.user_default.dimple.operators import haptic, live

    body = add()
    connect(bpy, port.path)
    run(bpy, body)
    live.advance(bpy.context, 1 / 60)
    connection().device.process.kill()
    until = time.perf_counter() + PATIENCE
    while connection().report.link.name != "LOST" and time.perf_counter() < until:
        time.sleep(haptic.LOOK_S)
        haptic._look()
    assert "onnect" in live.advance(bpy.context, 1 / 60)[0]


@pytest.mark.parametrize("how", ["file", "disable", "disconnect"])
def test_whatever_ends_it_ends_the_servo_and_frees_the_port(bpy: ModuleType, port: Any, how: str) -> None:
    from bl_ext.user_default.dimple.operators import device, haptic

    connect(bpy, port.path)
    servo = connection().device.process.pid
    if how == "file":
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    elif how == "disable":
        device.unregister()
        device.register()
    else:
        bpy.ops.dimple.connect_device()
    assert haptic.get() is None and gone(servo)
    connect(bpy, port.path)


def test_a_port_that_is_not_there_is_refused_with_the_reason(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators import haptic

    settings = bpy.context.scene.dimple
    with pytest.raises(RuntimeError, match="Choose a port"):
        bpy.ops.dimple.connect_device()
    settings.device_port = "/dev/nothing"
    bpy.ops.dimple.connect_device()
    assert "no port /dev/nothing" in wait(lambda report: report.link.name == "REFUSED").message
    haptic.disconnect()


def test_a_device_to_try_needs_no_port(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators import haptic

    connect(bpy, "emulated")
    assert ("emulated", "") in haptic.ports()
    haptic.disconnect()


def test_a_device_file_that_is_not_right_is_said(bpy: ModuleType, empty_file: ModuleType, tmp_path: Path) -> None:
    from bl_ext.user_default.dimple.operators import haptic

    settings = bpy.context.scene.dimple
    settings.device_file = str(tmp_path / "device.toml")
    (tmp_path / "device.toml").write_text('name = "Mine"')
    settings.device_port = "/dev/null"
    bpy.ops.dimple.connect_device()
    assert "device.toml has no 'blocks'" in wait(lambda report: report.link.name == "REFUSED").message
    haptic.disconnect()
    settings.device_port = "emulated"
    with pytest.raises(RuntimeError, match="did not start .*device.toml has no 'blocks'"):
        bpy.ops.dimple.connect_device()
