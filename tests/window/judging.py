"""The sensory comparison in the window test: two participants feel two stiffnesses in opposite orders, and a reader of
the whole screen sees the same.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import clicking
import device
import numpy as np
import robot

TAB = "Comparison"
FILE = Path("/tmp/window-experiment.json")
STIFF, SOFT = {"object": "A"}, {"object": "A", "level": 0.5}
PLAN = {
    "consent": "Do you agree?", "instruction": "Press each object.", "question": "Which was stiffer?",
    "answers": ["First", "Second"], "exposure_s": 2, "trial_s": 15, "press_n": 2, "objects": {"A": "Felt"},
    "participants": {"P01": [{"show": [STIFF, SOFT]}], "P02": [{"show": [SOFT, STIFF]}]},
}  # fmt: skip
STATUS_BAR = 24  # [px]
FAR = (0.0, 0.0, 50.0)  # [scene units] where no fingertip of the device is seen


def judge(body: str, out: Path, check: Callable[..., None]) -> robot.Waits:
    """Look for the answer on the screen while the stiffer and the softer object are presented."""
    experiments = robot.extension("operators.experiment.blind_trial").experiments
    processes, port = robot.extension("core.device.process"), out / "haptic"
    haptics = robot.extension("operators.press.haptic_fingertips")
    sessions = robot.extension("operators.press.sessions")
    obj, rest = bpy.data.objects[body], robot.positions(body).copy()
    own = obj.active_material
    obj.active_material = bpy.data.materials.new("Felt")
    felt = obj.active_material.dimple
    felt.K1, felt.K2, felt.x0 = 0.1, 0.1, 30.0
    obj.dimple.enabled = True
    emulator = processes.start(["emulator", "--lifeline", "--pty", str(port)], None, script=device.BENCH)
    yield from robot.until(port.exists, "the emulated device has a port", 60)
    haptics.choice().device_port, bpy.context.scene.dimple.device_origin = str(port), FAR
    panel = device.open_panel("DIMPLE_PT_experiment", TAB)
    for area in robot.window().screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = "MATERIAL"
    yield from robot.show_tab(TAB)
    bpy.ops.dimple.connect_device()
    yield from robot.until(lambda: haptics.get().report.states > 10, "the emulated device answers", 60)
    FILE.write_text(json.dumps(PLAN))
    for old in FILE.parent.glob(f"{FILE.stem}_*.csv"):
        old.unlink()
    pictures, stiffness = [], []
    for code in PLAN["participants"]:
        bpy.ops.dimple.open_experiment(filepath=str(FILE), participant=code)
        yield from device.photograph(out / f"15-consent-{code}.png")
        if pictures:
            bpy.ops.dimple.continue_experiment()  # it takes minutes to find a button
        else:
            yield from robot.click(*(yield from clicking.button("continue_experiment")))
            yield from robot.redrawn()
        check(f"{code} agrees", experiments[0].agreed)
        for interval in (1, 2):
            with robot.inside():
                bpy.ops.dimple.continue_experiment("INVOKE_DEFAULT")
            stiffness.append(float(sessions.get(obj).session.model.materials[0].K1))
            pictures.append((yield from looked(out / f"16-{code}-{interval}.png")))
            experiments[0].intervals[-1].seconds = 10.0  # as if it had been felt for long enough
        bpy.ops.dimple.answer_trial(choice=2)
        bpy.ops.dimple.stop_experiment()
    check("two stiffnesses were presented in both orders", stiffness == [100.0, 50.0, 50.0, 100.0], f"{stiffness}")
    for interval in (0, 1):
        off = different(pictures[interval], pictures[interval + 2])
        check(f"the whole screen is the same for both in interval {interval + 1}", off == 0, f"{off} px differ")
    yield from robot.show_tab("Dimple")  # where the material is
    before = yield from looked(out / "17-own.png")
    felt.K1 = 0.05
    after = yield from looked(out / "18-softer.png")
    off = different(before, after)
    check("and the reader sees it where nobody judges and the material is changed", off > 20, f"{off} px differ")
    for code in PLAN["participants"]:
        rows = FILE.with_name(f"{FILE.stem}_{code}.csv").read_text().splitlines()
        check(f"consent and answer of {code} are in a file", len(rows) == 3, rows[-1])
    bpy.ops.dimple.connect_device()  # lets go of it
    processes.end(emulator)
    obj.active_material = own
    check("the object has its shape, bit for bit", bool((robot.positions(body) == rest).all()))
    bpy.utils.unregister_class(panel)


def looked(path: Path) -> robot.Waits:
    """Return the whole screen but the status bar, which names keys; once the mouse has left the buttons."""
    for place in ((0.2, 0.0, 0.0), (0.0, 0.0, 0.0)):
        yield from robot.move(*robot.on_screen(place))
        yield from robot.looks(6)
    for area in robot.window().screen.areas:
        area.tag_redraw()
    yield from robot.redrawn(2)
    return robot.screenshot(path)[: robot.HEIGHT - STATUS_BAR]


def different(one: np.ndarray, other: np.ndarray) -> int:
    """Count the pixels of the screen that differ by more than 6 of 255."""
    return int((np.abs(one.astype(np.int16) - other.astype(np.int16)).max(axis=2) > 6).sum())
