"""The body that is touched runs in the process of the device, and Blender shows it."""

import signal
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.device_rig import connect, connection, gone, run, softened, strongest, wait
from tests.haptics.machine import NEEDS_PTY

pytestmark = NEEDS_PTY


def runs(report: Any) -> bool:
    return report.body.name == "RUNS"


def soft(bpy: ModuleType, add: Callable[..., Any]) -> Any:
    """Return a soft cube that is cut fine enough for a fingertip: for a wide one, into few vertices."""
    bpy.context.scene.dimple.finger_radius_mm = 15.0
    body = add()
    body.dimple.simulated = "AUTO"
    softened(bpy, body).friction = 0.1
    return body


def pressed(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> tuple[Any, Any]:
    """Return a body that runs beside the device, and its session; its fingertips press."""
    body = soft(bpy, add)
    entry = run(bpy, body, plays=True)
    connect(bpy, port.path)
    wait(runs, bpy)
    wait(lambda report: runs(report) and strongest(report) > 0.5, bpy, arms=True)
    return body, entry


def test_the_hand_gets_the_force_of_the_body_that_blender_shows(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    """All three rest, so near each other that they share a dent: each gets less than its law of 200 N/m alone."""
    _, entry = pressed(bpy, port, add)

    def rests(report: Any) -> bool:
        forces, depths = entry.frame.finger_forces, entry.frame.depths
        return (
            len(depths) == 3
            and depths.min() > 0.003
            and all(
                tip.force[2] == pytest.approx(force[2], rel=0.2) and 0.4 < force[2] / (200 * depth) < 0.9
                for tip, force, depth in zip(report.tips, forces, depths, strict=True)
            )
        )

    report = wait(rests, bpy, arms=True)
    assert runs(report) and 0 < report.load < 0.6
    rest = entry.session.model.matching.rest
    assert (rest.T - entry.session.skin())[:, 2].max() > 0.002, "the dent shows"


@pytest.mark.once
def test_a_blender_that_stalls_leaves_the_force_as_it_was(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> None:
    """For 0.2 s, over which a wall has faded: the body goes on at the device's rate."""
    pressed(bpy, port, add)
    for _ in range(20):  # a machine that stands still itself disarms
        before = wait(lambda report: strongest(report) > 0.5, bpy, arms=True)
        time.sleep(0.2)
        after = connection().device.read()
        if before.arming.name == after.arming.name == "ON" and after.tips[0].force[2] > 0.5:
            assert strongest(after) > 0.5 and after.states > before.states + 50
            return
    raise AssertionError(after)


@pytest.mark.once
@pytest.mark.parametrize("who", ["servo", "emulator"])
def test_a_killed_process_leaves_the_body_with_blender(
    bpy: ModuleType, port: Any, add: Callable[..., Any], who: str
) -> None:
    from bl_ext.user_default.dimple.operators import live

    body, entry = pressed(bpy, port, add)
    local, servo = entry.session.body.local, connection().device.process
    (servo if who == "servo" else port.process).send_signal(signal.SIGKILL)
    report = wait(lambda report: report.link.name == "LOST", bpy)
    assert strongest(report) == 0.0 or report.arming.name == "OFF"
    assert gone(servo.pid) and entry.session.body is local
    before = entry.frame.time
    live.advance(bpy.context, 0.5)
    assert entry.frame.time > before
    rest, at = local.model.matching.rest, local.positions()
    assert np.abs(at - rest).max() < 1e-3, "nothing presses it any more"


@pytest.mark.once
def test_a_body_that_blows_up_beside_the_device_has_no_force_and_is_put_back_to_rest(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    from bl_ext.user_default.dimple.operators import live

    _, entry = pressed(bpy, port, add)
    remote, notes = entry.session.body, []
    remote.set_state(remote.positions() + 1e9 * np.random.default_rng(0).random(remote.positions().shape))
    for _ in range(600):
        notes += live.advance(bpy.context, 1 / 60)
        time.sleep(1 / 60)
        if any("blew up" in note for note in notes):
            break
    assert any("blew up" in note for note in notes)
    report = wait(lambda report: report.arming.name == "OFF", bpy)
    assert strongest(report) == 0.0 and np.isfinite(entry.session.positions()).all()


@pytest.mark.once
def test_a_body_too_fine_for_the_device_is_a_wall_and_the_panel_says_so(
    bpy: ModuleType, port: Any, add: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.addon import device
    from bl_ext.user_default.dimple.operators import beside, live

    body = soft(bpy, add)
    settings = body.active_material.dimple
    entry = run(bpy, body, plays=True)
    connect(bpy, port.path)
    monkeypatch.setattr(beside, "HEAVIEST", 0.0)
    for _ in range(30):
        live.advance(bpy.context, 1 / 60)
        time.sleep(1 / 60)
    report = connection().report
    assert report.body.name == "NONE" and not connection().beside.runs
    assert any("too fine to run" in note for note in device.notes(report, settings))
    assert dict(device.rows(report, settings))["Rendered"] == "Local Wall (Measured Law)"
    monkeypatch.undo()
    bpy.context.scene.dimple.finger_radius_mm += 0.1  # looked at anew
    report = wait(runs, bpy)
    assert dict(device.rows(report, settings))["Rendered"].startswith("Model")
    assert not any("too fine to run" in note for note in device.notes(report, settings))
    assert entry.session.body is connection().beside.remote


ONCE = pytest.mark.once


@pytest.mark.parametrize("why", ["mouse", pytest.param("collider", marks=ONCE), pytest.param("reset", marks=ONCE)])
def test_what_only_blender_can_step_comes_back_to_it(
    bpy: ModuleType, port: Any, add: Callable[..., Any], why: str
) -> None:
    """The mouse presses it too, bodies meet, or nothing runs; a fingertip that was inside it is not pushed."""
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators import live

    body, entry = pressed(bpy, port, add)
    if why == "reset":
        bpy.ops.dimple.reset()
    elif why == "collider":
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 40))
        bpy.context.object.dimple.collider = True
    mouse = Finger((0.0, 0.0, entry.link.scale + 0.050), 0.010)
    for _ in range(30):
        live.advance(bpy.context, 1 / 60, pressed={entry.link.uid: (mouse,)} if why == "mouse" else None)
        if why == "reset":
            time.sleep(0.1)
            from bl_ext.user_default.dimple.operators import haptic

            haptic._look()
        time.sleep(1 / 60)
    assert not connection().beside.runs and connection().report.body.name == "NONE"
    assert connection().report.arming.name == "OFF"
    if why == "mouse":
        wait(runs, bpy)


@pytest.mark.once
def test_a_constant_that_is_changed_goes_to_the_body_that_runs(
    bpy: ModuleType, port: Any, add: Callable[..., Any]
) -> None:
    body, entry = pressed(bpy, port, add)
    remote, before = entry.session.body, connection().report.parcel
    body.active_material.dimple.damping_ratio = 0.9
    report = wait(lambda report: report.parcel > before, bpy)
    assert runs(report) and entry.session.body is remote
    assert remote.model.materials[0].damping_ratio == pytest.approx(0.9)
    assert remote.model.friction.max() == pytest.approx(0.1), "and the friction of the material from the start"
