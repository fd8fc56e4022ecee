"""The job type of Flamenco, Blender's render manager, is compiled by a JavaScript engine; what it asks for is done."""

import json
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.point_cache import read_point_cache
from tools.environment import ROOT, provide_readers

SCRIPT = ROOT / "tools" / "flamenco" / "dimple-bake.js"
TYPES = {"string", "int32", "float", "bool"}  # that a setting of Flamenco has
KEYS = set("key type subtype choices propargs description default eval evalInfo visible required editable".split())


def compiled(**settings: Any) -> dict[str, Any]:
    readers = provide_readers(Path(sys.executable))
    command = [sys.executable, str(ROOT / "tests/blender/export/compile_job.py"), str(SCRIPT), json.dumps(settings)]
    done = subprocess.run(command, env={"PYTHONPATH": str(readers)}, capture_output=True, text=True, timeout=120)
    if done.returncode:
        raise ValueError(done.stderr)
    return json.loads(done.stdout)


def called(command: dict[str, Any]) -> list[str]:
    """Return the words that a worker calls for the command "blender-render", by Flamenco's documentation."""
    assert command["name"] == "blender-render"
    asked = command["parameters"]
    variables = {"{blender}": "/opt/blender/blender", "{blenderArgs}": "-b -y"}  # as the manager replaces them
    before = [variables[asked["exe"]], *shlex.split(variables[asked["exeArgs"]]), *asked["argsBefore"]]
    return [*before, asked["blendfile"], *asked["args"]]


def test_the_settings_are_those_that_flamenco_knows(bpy: ModuleType) -> None:
    given = {"objects": '["Ball"]', "frames": "1-3", "formats": "pc2", "output": "/out", "blendfile": "a.blend"}
    kind = compiled(**given)["type"]
    assert kind["label"] == "Dimple Bake"
    for setting in kind["settings"]:
        assert setting["type"] in TYPES and set(setting) <= KEYS, setting["key"]
    assert "blendfile" in {setting["key"] for setting in kind["settings"]}


def test_what_the_submitter_evaluates_in_blender_is_right(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any]
) -> None:
    ball('Ball, "one"').dimple.enabled = True
    ball("柔らかい").dimple.enabled = True
    ball("No body").dimple.enabled = False
    scene.frame_start, scene.frame_end = 3, 9
    given = {"objects": '["Ball"]', "frames": "1-3", "formats": "pc2", "output": "/out", "blendfile": "a.blend"}
    settings = {setting["key"]: setting for setting in compiled(**given)["type"]["settings"]}
    evaluated = {key: eval(each["eval"], {"C": bpy.context}) for key, each in settings.items() if "eval" in each}
    assert json.loads(evaluated["objects"]) == ['Ball, "one"', "柔らかい"] and evaluated["frames"] == "3-9"


def test_bodies_that_meet_in_play_are_one_task_and_meet_in_its_bake(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any], tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators.export import command_line

    for name, height in (("Lower", 0.0), ("Upper", 2.05)):
        body = ball(name)
        body.location.z, body.dimple.enabled, body.dimple.self_contact = height, True, name == "Lower"
        body.dimple.pinned = name == "Lower"
    scene.dimple.use_gravity, scene.dimple.use_ground = True, False
    blend, out = tmp_path / "meeting.blend", tmp_path / "out"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    given = {"frames": "1-7", "formats": "pc2", "output": str(out), "overwrite": True, "blendfile": str(blend)}
    asked = {each["key"]: each for each in compiled(objects='["Ball"]', **given)["type"]["settings"]}["objects"]["eval"]
    gaps = []
    for objects in (eval(asked, {"C": bpy.context}), '["Lower", "Upper"]'):
        tasks = compiled(objects=objects, **given)["tasks"]
        for task in tasks:
            assert command_line.run(called(task["commands"][0])[5:]) == 0
        low, high = (read_point_cache(out / f"{name}.pc2")[2][-1] for name in ("Lower", "Upper"))
        gaps.append((high[:, 2] + 2.05).min() - low[:, 2].max())
    assert gaps[0] > 0 > gaps[1], "apart they pass through each other"
    assert [task["name"] for task in tasks] == ["bake-Lower", "bake-Upper"]
    assert compiled(objects='[["Lower", "Upper"]]', **given)["tasks"][0]["name"] == "bake-Lower-Upper"


def test_the_tasks_of_two_bodies_bake_both(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], ball: Callable[..., Any], tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators.export import command_line

    pressed().dimple.enabled = True
    other = ball("--an odd name")
    other.dimple.enabled, other.location.x = True, 5
    blend, out = tmp_path / "the press.blend", tmp_path / "out"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    job = compiled(
        objects=json.dumps(["Ball", "--an odd name"]), frames="1-7", formats="pc2,abc", output=str(out),
        overwrite=False, blendfile=str(blend),
    )  # fmt: skip
    assert [task["name"] for task in job["tasks"]] == ["bake-Ball", "bake---an odd name"]
    assert {task["type"] for task in job["tasks"]} == {"blender"}
    for task in job["tasks"]:
        for command in task["commands"]:
            words = called(command)
            assert words[:5] == ["/opt/blender/blender", "-b", "-y", "--command", "dimple"]
            assert command_line.run(words[5:]) == 0  # Blender hands what follows the name of the command to it
    assert len(list(out.glob("*.pc2"))) == len(list(out.glob("*.abc"))) == 2
    assert len(read_point_cache(out / "Ball.pc2")[2]) == 7


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"objects": "[]"}, "There is no Dimple body"),
        ({"objects": "[[]]"}, "There is no Dimple body"),
    ],
)
def test_a_job_that_makes_no_sense_is_refused_when_it_is_sent(
    bpy: ModuleType, change: dict[str, str], sentence: str
) -> None:
    given = {"objects": '["Ball"]', "frames": "1-3", "formats": "pc2", "output": "/out", "blendfile": "a.blend"}
    with pytest.raises(ValueError, match=sentence):
        compiled(**{**given, **change})
