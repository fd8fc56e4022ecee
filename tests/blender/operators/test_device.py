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
PATIENCE = 10.0  # [s] on a busy machine
BEGIN = 1.2  # [s] from the device's ramp until the servo's is over
WAY = [[0.0, 0.0, 0.0, 0.02], [BEGIN, 0.0, 0.0, 0.02], [BEGIN + 0.2, 0.0, 0.0, -0.010]]
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
    while not os.path.lexists(path) and time.perf_counter() < until:
        time.sleep(0.01)
    yield SimpleNamespace(path=str(path), process=process)
    haptic.disconnect()
    sessions.stop_all()
    end(process)


def connection() -> Any:
    from bl_ext.user_default.dimple.operators import haptic

    return haptic.get()


def wait(holds: Callable[[Any], bool], bpy: ModuleType | None = None) -> Any:
    """Let time pass until something holds of the report; with bpy, let the sessions run as Play does."""
    from bl_ext.user_default.dimple.operators import haptic, live

    until = time.perf_counter() + PATIENCE
    while not holds(connection().report):
        assert time.perf_counter() < until, connection().report
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
    wait(lambda report: strongest(report) > 0.5, bpy)
    time_up = time.perf_counter() + 0.5
    report = wait(lambda _: time.perf_counter() > time_up, bpy)
    assert len([finger for finger in entry.fingers if finger]) == 3  # which the overlay draws
    depths = entry.frame.depths
    assert depths.min() > 0.003
    for tip, depth in zip(report.tips, depths, strict=True):
        assert tip.force[2] == pytest.approx(200 * depth, rel=0.1)


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


def test_the_key_is_the_dead_man_switch(bpy: ModuleType, port: Any) -> None:
    """Press, release, another window in front: the modal operator follows, and Esc disarms."""
    from bl_ext.user_default.dimple.operators.device import DIMPLE_OT_arm_device

    connect(bpy, port.path)
    window = SimpleNamespace(modal_handler_add=lambda _: None)
    workspace = SimpleNamespace(status_text_set=lambda _: None)
    context = SimpleNamespace(window_manager=window, workspace=workspace)
    names = ("invoke", "modal", "cancel", "_end", "_is_armed")
    operator = type("Stub", (), {name: DIMPLE_OT_arm_device.__dict__[name] for name in names})()

    def send(kind: str, value: str = "PRESS") -> bool:
        operator.modal(context, SimpleNamespace(type=kind, value=value))
        return connection().held_until > time.perf_counter()

    assert operator.invoke(context, None) == {"RUNNING_MODAL"}
    assert not send("MOUSEMOVE", "NOTHING")
    assert send("LEFT_SHIFT") and not send("LEFT_SHIFT", "RELEASE")
    assert send("LEFT_SHIFT") and not send("WINDOW_DEACTIVATE", "NOTHING")
    assert send("LEFT_SHIFT")
    wait(lambda report: report.arming.name == "ON")
    assert not send("ESC")
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
    wait(lambda report: strongest(report) > 0.5, bpy)
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
    assert rows["K1"] == "0.20: 0.20 N/mm"
    asked, _, rendered = rows["K2"].partition(": ")
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
