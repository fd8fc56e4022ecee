"""The haptic device in Blender."""

import contextlib
import json
import signal
import socket
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.operators.device_rig import (
    BENCH,
    PATIENCE,
    connect,
    connection,
    gone,
    run,
    softened,
    strongest,
    under_device,
    wait,
)
from tests.haptics.machine import NEEDS_PTY
from tools.environment import ROOT

pytestmark = NEEDS_PTY


def test_three_fingertips_press_the_session_and_get_its_force(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    entry = under_device(bpy, port, add)
    assert bpy.ops.dimple.arm_device(hold_s=60.0) == {"FINISHED"}

    def pressed(report: Any) -> bool:
        """All three rest at a depth, with the force of 200 N/m."""
        depths = entry.frame.depths
        return (
            len(depths) == 3
            and depths.min() > 0.003
            and all(
                tip.force[2] == pytest.approx(200 * depth, rel=0.1)
                for tip, depth in zip(report.tips, depths, strict=True)
            )
        )

    wait(pressed, bpy, arms=True)
    assert len([finger for finger in entry.fingers if finger]) == 3  # which the overlay draws


@pytest.mark.slow
def test_an_inverse3_is_felt_on_suzanne_by_the_ten_steps_of_the_page(bpy: ModuleType, empty_file: ModuleType) -> None:
    """Steps 3 to 10 of docs/device.md; Shift is `hold_s`, and the hand is that of the bench: it pokes 22 mm deep."""
    from bl_ext.user_default.dimple.core.device.process import end, start
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips, live_step, sessions

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    service = start(["emulator", "--lifeline", "--haply", str(number)], None, script=BENCH)
    time.sleep(2.0)
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "blend_samples" / "suzanne.blend"))
    assert ("haply:10001", "Haply Inverse3") in haptic_fingertips.ports()
    connect(bpy, f"haply:{number}")
    body = next(each for each in bpy.context.scene.objects if each.type == "MESH" and each.dimple.enabled)
    bpy.context.scene.cursor.location = max((body.matrix_world @ v.co for v in body.data.vertices), key=lambda at: at.z)
    assert bpy.ops.dimple.centre_device() == {"FINISHED"}
    live_step.start_all(bpy.context)
    assert bpy.ops.dimple.arm_device(hold_s=60.0) == {"FINISHED"}
    wait(lambda report: strongest(report) > 0.2, bpy, arms=True)
    haptic_fingertips.hold(0.0)
    wait(lambda report: strongest(report) == 0.0, bpy)
    haptic_fingertips.disconnect()
    sessions.stop_all()
    end(service)


@pytest.mark.once
@pytest.mark.parametrize("who", ["servo", "emulator"])
def test_a_killed_process_takes_the_force_and_not_the_session(
    bpy: ModuleType, port: Any, add: Callable[..., Any], who: str
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    entry = under_device(bpy, port, add)
    bpy.ops.dimple.arm_device(hold_s=60.0)
    wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
    servo = connection().device.process
    (servo if who == "servo" else port.process).send_signal(signal.SIGKILL)
    notes: list[str] = []
    until = time.perf_counter() + PATIENCE
    while not notes and time.perf_counter() < until:
        notes += live_step.advance(bpy.context, 1 / 60)
        time.sleep(1 / 60)
    assert "onnect" in notes[0]
    assert gone(servo.pid)
    before = entry.frame.time
    assert live_step.advance(bpy.context, 1 / 60) == []
    assert sessions.get(entry.obj) is entry and entry.frame.time > before
    assert not bpy.ops.dimple.arm_device.poll()


def test_the_panel_says_what_is_not_renderable(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    from bl_ext.user_default.dimple.addon import device

    settings = softened(bpy, add())
    report = connect(bpy, port.path)
    assert any("K2 cannot be rendered" in note for note in device.notes(report, settings))
    rows = dict(device.rows(report, settings))
    assert rows["K1 Material / Rendered"] == "0.20 / 0.20 N/mm"
    asked, _, rendered = rows["K2 Material / Rendered"].partition(" / ")
    assert (
        asked == "9.00"
        and float(rendered.split()[0]) == pytest.approx(report.cap / 1e3, abs=0.006)
        and report.cap < 1400
    )
    assert rows["State"] == "Ready, no force" and {"Rate", "Lost Frames", "Delay", "Force 1"} <= rows.keys()
    settings.K1 = 9.0
    assert any("K1, K2 cannot" in note for note in device.notes(report, settings))
    assert any("more force than the device can exert" in note for note in device.notes(report, settings))
    cap = report.cap / 1e3  # a solid's law of the same power, no steeper than that
    settings.fill, settings.K1, settings.K2, settings.x0 = "SOLID", 0.8 * cap, 2.25 * 0.8 * cap, 1.0
    assert any("K1, K2 cannot" in note for note in device.notes(report, settings))
    rendered = dict(device.rows(report, settings))["K1 Material / Rendered"].partition(" / ")[2]
    assert float(rendered.split()[0]) == pytest.approx(cap / 2.25, abs=0.006)
    assert device.knee_force(settings) == pytest.approx(1.162 * settings.K1, rel=1e-3)


def test_the_origin_is_where_the_fingertips_are(bpy: ModuleType, port: Any) -> None:
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    connect(bpy, port.path)
    scene = bpy.context.scene
    scene.cursor.location = (1.0, 2.0, 3.0)
    scene.dimple.device_scale = 2.5
    assert bpy.ops.dimple.centre_device() == {"FINISHED"}
    tips = [tip.position for tip in connection().report.tips]
    middle = tuple(sum(tip[c] for tip in tips) / 3 for c in range(3))
    at = haptic_fingertips.workspace(scene, 0.1).to_session(middle)
    assert at == pytest.approx((0.1, 0.2, 0.3), abs=1e-5)


@pytest.mark.parametrize("paused", [True, pytest.param(False, marks=pytest.mark.once)], ids=["paused", "nothing runs"])
def test_a_servo_hears_of_blender_while_nothing_moves(
    bpy: ModuleType, port: Any, add: Callable[..., Any], paused: bool
) -> None:
    """Where its pipe cannot be watched (Windows) a servo that hears nothing for 10 s takes Blender for gone."""
    from bl_ext.user_default.dimple.core.device.mailbox import TO_SERVO
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    body = add()
    connect(bpy, port.path)
    if paused:
        run(bpy, body)
    seen = 0
    for _ in range(3):
        time.sleep(haptic_fingertips.LOOK_S)
        haptic_fingertips._look()
        seen, order = connection().device._box.read(TO_SERVO, seen)
        assert order


def test_a_fingertip_that_is_not_trusted_moves_no_other(
    bpy: ModuleType, port: Any, add: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    connect(bpy, port.path)
    entry = run(bpy, add())
    live_step.advance(bpy.context, 1 / 60)
    tips, device = connection().report.tips, type(connection().device)
    for masked in ((True, False, False), (False, True, True), (True, True, True)):
        spoiled = [tip._replace(masked=mask) for tip, mask in zip(tips, masked, strict=True)]
        report = connection().report._replace(tips=tuple(spoiled))
        monkeypatch.setattr(device, "read", lambda _, report=report: report)
        assert live_step.advance(bpy.context, 1 / 60) == []
        assert [finger is None for finger in entry.fingers] == list(masked)


def test_a_device_that_is_lost_while_play_is_paused_is_said_when_it_goes_on(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips, live_step

    connect(bpy, port.path)
    run(bpy, add())
    live_step.advance(bpy.context, 1 / 60)
    connection().device.process.kill()
    until = time.perf_counter() + PATIENCE
    while connection().report.link.name != "LOST" and time.perf_counter() < until:
        time.sleep(haptic_fingertips.LOOK_S)
        haptic_fingertips._look()
    assert "onnect" in live_step.advance(bpy.context, 1 / 60)[0]


@pytest.mark.parametrize("how", ["file", "disable", "disconnect"])
def test_whatever_ends_it_ends_the_servo_and_frees_the_port(bpy: ModuleType, port: Any, how: str) -> None:
    from bl_ext.user_default.dimple.operators.device import connect_device
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    connect(bpy, port.path)
    servo = connection().device.process.pid
    if how == "file":
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    elif how == "disable":
        connect_device.unregister()
        connect_device.register()
    else:
        bpy.ops.dimple.connect_device()
    assert haptic_fingertips.get() is None and gone(servo)
    assert not bpy.app.timers.is_registered(haptic_fingertips._look), "else it goes on with the next device"
    connect(bpy, port.path)


def test_a_port_that_is_not_there_is_refused_with_the_reason(bpy: ModuleType, empty_file: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    settings = haptic_fingertips.choice()
    settings.device_port = ""
    with pytest.raises(RuntimeError, match="Choose a port"):
        bpy.ops.dimple.connect_device()
    settings.device_port = "/dev/nothing"
    bpy.ops.dimple.connect_device()
    assert "no port /dev/nothing" in wait(lambda report: report.link.name == "REFUSED").note
    haptic_fingertips.disconnect()


def test_the_owner_of_an_inverse3_connects_presses_and_feels(
    bpy: ModuleType, add: Callable[..., Any], tmp_path: Path
) -> None:
    """The ten lines of docs/device.md, with the service of the test bench."""
    from bl_ext.user_default.dimple.core.device.process import end, start
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    with socket.create_server(("127.0.0.1", 0)) as free:
        number = free.getsockname()[1]
    way = [[0.0, 0.05, -0.10, 0.12]] + [
        [8 * k + t, 0.05, -0.10, z] for k in range(8) for t, z in ((2.0, 0.12), (3.0, 0.09), (7.0, 0.09), (8.0, 0.12))
    ]
    (tmp_path / "hand.json").write_text(json.dumps({"tips": [way, way[:1], way[:1]]}))
    words = ["emulator", "--lifeline", "--haply", str(number), "--hand", str(tmp_path / "hand.json")]
    service = start(words, None, script=BENCH)
    try:
        for _ in range(50):
            time.sleep(0.1)
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", number), 0.1):
                break
        connect(bpy, f"haply:{number}")
        body = add()
        softened(bpy, body)
        entry = run(bpy, body)
        at = connection().report.tips[0].position
        settings = bpy.context.scene.dimple
        settings.device_centre_mm = [1e3 * at[0], 1e3 * at[1], 1e3 * 0.105]  # the hand goes 15 mm below
        wait(lambda report: report.tips[0].force[2] > 0.3, bpy, arms=True)
        assert entry.frame.depths[0] > 0.0
    finally:
        haptic_fingertips.disconnect()
        end(service)


def test_a_file_brings_no_device_and_another_computer_is_reached_only_where_that_is_allowed(
    bpy: ModuleType, empty_file: ModuleType, tmp_path: Path
) -> None:
    """The port is a setting of this computer: what a stranger's file names connects to nothing, by no click."""
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    of_scene = set(bpy.context.scene.dimple.bl_rna.properties.keys())
    assert not {"device_port", "device_secret", "device_anywhere"} & of_scene
    settings = haptic_fingertips.choice()
    settings.device_port, settings.device_secret = "udp:192.0.2.1:7400", "a secret of this test alone"
    settings.device_anywhere = not bpy.app.online_access  # allowed here, but not by Blender; or the other way about
    bpy.ops.dimple.connect_device()
    assert "another computer" in wait(lambda report: report.link.name == "REFUSED").note
    haptic_fingertips.disconnect()
    settings.device_port, settings.device_secret, settings.device_anywhere = "", "", False


def test_a_blender_that_draws_too_slowly_for_the_dead_man_key_is_said_once(
    bpy: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.device.force_guard import Arming
    from bl_ext.user_default.dimple.core.device.orders import LinkState
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    report = SimpleNamespace(link=LinkState.READY, arming=Arming.ON, note="")
    clock = SimpleNamespace(now=100.0, perf_counter=lambda: clock.now)
    monkeypatch.setattr(haptic_fingertips, "time", clock)
    monkeypatch.setattr(haptic_fingertips, "connections", [
        haptic_fingertips.Connection(device=SimpleNamespace(read=lambda: report), report=report)
    ])  # fmt: skip
    said = []
    for frame_s in (0.02, 0.02, 0.5, 0.5, 0.02, 0.4):
        clock.now += frame_s
        said.append(haptic_fingertips.read())
    assert [bool(each) for each in said] == [False, False, True, False, False, True]
    assert said[2][0].startswith("Blender draws only 2.0 frames a second, so the dead-man key times out")
    assert haptic_fingertips.get().slow
    report.link, clock.now = LinkState.LOST, clock.now + 0.4
    haptic_fingertips.read()
    assert not haptic_fingertips.get().slow, "of a device that is lost, only that is said"
