"""A haptic device for Blender's tests: an emulated one in a process of its own, behind a real pseudo-terminal."""

import json
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.haptics.machine import unable
from tools.environment import ROOT

BENCH = ROOT / "studies" / "bench" / "start.py"
PATIENCE = 30.0  # [s] on a busy machine; counted in frames, for one may stand still for longer
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
    from bl_ext.user_default.dimple.core.device.process import end, start
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips, sessions

    tips = [[[t, x + shift, y, z] for t, x, y, z in WAY] for shift in (-APART, 0.0, APART)]
    (tmp_path / "hand.json").write_text(json.dumps({"tips": tips}))
    path = tmp_path / "port"
    words = ["emulator", "--lifeline", "--pty", str(path), "--hand", str(tmp_path / "hand.json")]
    process = start(words, None, script=BENCH)
    until = time.perf_counter() + PATIENCE
    while not os.path.exists(path) and time.perf_counter() < until:
        time.sleep(0.01)
    yield SimpleNamespace(path=str(path), process=process)
    haptic_fingertips.disconnect()
    sessions.stop_all()
    end(process)


def connection() -> Any:
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    return haptic_fingertips.get()


def wait(holds: Callable[[Any], bool], bpy: ModuleType | None = None, *, arms: bool = False) -> Any:
    """Let time pass until something holds of the report; with bpy, let the sessions run as Play does.

    arms: ask for force, again where the machine was too busy.
    """
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips, live_step

    asked = 0.0
    for _ in range(round(60 * PATIENCE)):
        if holds(connection().report):
            return connection().report
        if arms and connection().report.arming.name == "OFF" and time.perf_counter() - asked > AGAIN:
            asked = time.perf_counter()
            haptic_fingertips.hold(60.0)
            connection().device.arm()
        if bpy:
            live_step.advance(bpy.context, 1 / 60)
        else:
            haptic_fingertips._look()
        time.sleep(1 / 60)
    if arms and "silent" in connection().report.note:
        unable("this machine stood still for the 100 ms after which a device is lost")
    raise AssertionError(connection().report)


def connect(bpy: ModuleType, path: str) -> Any:
    """Connect; again where the machine stood still for the second in which a device must answer."""
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips

    haptic_fingertips.choice().device_port = path
    for _ in range(3):
        assert bpy.ops.dimple.connect_device() == {"FINISHED"}
        report = wait(lambda report: report.states > 10 or report.link.name == "REFUSED")
        if report.states > 10:
            return report
        bpy.ops.dimple.connect_device()  # lets go of it
    raise AssertionError(report)


def run(bpy: ModuleType, body: Any) -> Any:
    """Start a session on a body under the fingertips: the middle of the workspace is where they touch its top."""
    from bl_ext.user_default.dimple.operators.press import live_step, sessions

    live_step.start_all(bpy.context)
    entry = sessions.get(body)
    bpy.context.scene.dimple.device_origin = (0.0, 0.0, 1.0 + 0.010 / entry.link.scale)
    return entry


def softened(bpy: ModuleType, body: Any) -> Any:
    """Give a body a material that any machine's delay lets a device render."""
    material = bpy.data.materials.new("Soft")
    body.data.materials.append(material)
    material.dimple.K1, material.dimple.K2, material.dimple.x0 = 0.2, 9.0, 30.0
    return material.dimple


def under_device(bpy: ModuleType, port: Any, add: Callable[..., Any]) -> Any:
    """Start a session on a soft body under the fingertips of the device at a port."""
    body = add()
    softened(bpy, body)
    connect(bpy, port.path)
    return run(bpy, body)


def gone(pid: int) -> bool:
    for _ in range(300):
        status = Path(f"/proc/{pid}/stat")
        if not status.exists() or status.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.01)
    return False


def strongest(report: Any) -> float:
    return max(sum(c * c for c in tip.force) ** 0.5 for tip in report.tips)
