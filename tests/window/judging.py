"""The sensory comparison in the window test: consent, two presses seen in turn, answers, a felt object until Esc."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import device
import numpy as np
import robot

TAB = "Comparison"
FILE = Path("/tmp/window-experiment.json")
PLAN = {
    "name": "window", "seed": 1,
    "tasks": [
        {
            "kind": "comparison", "condition": "seen", "object": "object_2_vinyl_air", "repeats": 1,
            "method": "staircase", "start": 1.5,
        },
        {"kind": "rating", "condition": "felt", "object": "object_2_vinyl_air", "repeats": 1},
    ],
}  # fmt: skip


def judge(body: str, out: Path, check: Callable[..., None]) -> robot.Waits:
    """Go through an experiment of two trials by its buttons."""
    rest, experiment = robot.positions(body).copy(), robot.extension("operators.experiment.blind_trial")
    material = bpy.data.objects[body].active_material
    panel = device.open_panel("DIMPLE_PT_experiment", TAB)
    yield from robot.show_tab(TAB)
    yield from device.photograph(out / "15-experiment.png")
    FILE.write_text(json.dumps(PLAN))
    for old in FILE.parent.glob(f"{FILE.stem}*.csv"):
        old.unlink()
    bpy.ops.dimple.open_experiment(filepath=str(FILE), participant="P1")
    yield from device.photograph(out / "16-consent.png")
    yield from press("bpy.ops.dimple.agree_experiment()")
    check("the participant agrees by the button", experiment.get().agreed)
    while trial := experiment.trial():
        if trial.task.condition == "seen":
            yield from see(body, rest, out, check)
        else:
            yield from feel(body, out, check)
        yield from press("bpy.ops.dimple.answer_trial(choice=2)")
        yield from robot.until(lambda before=trial: experiment.trial() != before, "the answer is taken", 30)
    yield from device.photograph(out / "19-answered.png")
    rows = FILE.with_name(f"{FILE.stem}_P1_answers.csv").read_text().splitlines()
    check("both answers are in the file", len(rows) == 1 + len(PLAN["tasks"]), "; ".join(rows[1:]))
    yield from press("bpy.ops.dimple.stop_experiment()")
    mine = bpy.data.objects[body].active_material
    check("the object has its own material again", mine == material, f"{mine}")
    check("and its shape, bit for bit", bool((robot.positions(body) == rest).all()))
    bpy.utils.unregister_class(panel)
    yield from robot.show_tab("Dimple")


def see(body: str, rest: np.ndarray, out: Path, check: Callable[..., None]) -> robot.Waits:
    """Present both intervals: each is pressed and let go by itself."""
    for interval in (1, 2):
        yield from press(f"bpy.ops.dimple.show_trial(interval={interval})")
        dented = 0.0

        def moved() -> float:
            nonlocal dented
            now = float(np.linalg.norm(robot.positions(body) - rest, axis=1).max())
            dented = max(dented, now)
            return now

        yield from robot.until(lambda seen=moved: seen() > 0.05, f"interval {interval} is pressed", 120)
        yield from device.photograph(out / f"17-interval-{interval}.png")
        yield from robot.until(lambda seen=moved: not robot.modal_operators() and seen() == 0, "it is let go", 240)
        check(f"interval {interval} is pressed where it is seen, and let go", dented > 0.05, f"{dented:.3f} m")


def feel(body: str, out: Path, check: Callable[..., None]) -> robot.Waits:
    """Present an object to be felt: it waits for the device, until Esc."""
    yield from press("bpy.ops.dimple.show_trial(interval=1)")
    running = "DIMPLE_OT_show_trial" in robot.modal_operators()
    yield from device.photograph(out / "18-felt.png")
    yield from robot.key("ESC", *robot.on_screen((0.0, 0.0, 0.0)))
    yield from robot.until(lambda: not robot.modal_operators(), "Esc ends the trial", 30)
    check("an object to be felt is there until Esc", running)


def press(command: str) -> robot.Waits:
    """Click the button of a command in the sidebar."""
    buttons = yield from robot.find_buttons(command)
    if command not in buttons:
        raise robot.NotReached(f"no button of the sidebar calls {command}; there are {sorted(buttons)}")
    yield from robot.click(*buttons[command])
    yield from robot.redrawn()
