"""The command line bakes without a window: exit codes for scripts, one line of JSON for programs."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tools.environment import ROOT


@pytest.fixture
def blend(bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path) -> Path:
    """A saved file with one body, and a mesh that is none."""
    obj = pressed()
    obj.dimple.enabled = True
    scene.frame_start, scene.frame_end = 2, 5
    bpy.context.collection.objects.link(bpy.data.objects.new("Table", bpy.data.meshes.new("Table")))
    path = tmp_path / "press with spaces.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def command(bpy: ModuleType, capfd: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, dict[str, Any]]]:
    """Return a function that runs the command and returns its exit code and what it printed last."""
    from bl_ext.user_default.dimple.operators.export import command_line

    def run(*words: object) -> tuple[int, dict[str, Any]]:
        code = command_line.run(["bake", *map(str, words)])
        return code, json.loads(capfd.readouterr().out.splitlines()[-1])

    return run


def test_it_writes_every_format_and_says_so(command: Any, blend: Path, tmp_path: Path) -> None:
    out, summary = tmp_path / "new folder" / "out", tmp_path / "summary.json"
    code, said = command(blend, "--out", out, "--format", "abc,usd,glb,pc2", "--json", summary)
    assert code == 0 and said["ok"] and said["error"] is None
    assert said["objects"] == ["Ball"] and said["frames"] == [2, 5], "the bodies and frames of the scene"
    assert {Path(path).name for path in said["written"]} == {path.name for path in out.iterdir()}
    assert {path.suffix for path in out.iterdir()} == {".abc", "", ".glb", ".pc2", ".csv", ".json"}
    assert [path.name for path in (out / "Ball_usd").iterdir()] == ["Ball.usdc"]
    assert json.loads(summary.read_text()) == said


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--object", "Cube"], 'The scene has no object "Cube". Its Dimple bodies: Ball.'),
        (["--object", "Table"], '"Table" has no faces'),
        (["--frames", "9-3"], "must not come before the first"),
    ],
)
def test_what_cannot_be_done_is_said_with_exit_code_1(
    command: Any, blend: Path, tmp_path: Path, words: list[str], sentence: str
) -> None:
    code, said = command(blend, "--out", tmp_path / "out", *words)
    assert code == 1 and not said["ok"] and sentence in said["error"] and said["written"] == []


def test_files_that_are_no_scene_are_said_with_exit_code_1(command: Any, blend: Path, tmp_path: Path) -> None:
    (tmp_path / "text.blend").write_text("no scene")
    for path, sentence in ((tmp_path / "none.blend", "There is no file"), (tmp_path / "text.blend", "cannot open")):
        code, said = command(path, "--out", tmp_path / "out")
        assert code == 1 and sentence in said["error"]


def test_a_second_run_refuses_to_replace_the_files_of_the_first(command: Any, blend: Path, tmp_path: Path) -> None:
    words = (blend, "--out", tmp_path / "out", "--format", "pc2")
    assert command(*words)[0] == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    code, said = command(*words)
    assert code == 1 and "already exist" in said["error"]
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before
    assert command(*words, "--overwrite")[0] == 0


@pytest.mark.parametrize("words", [["--format", "abc,doc"], ["--frames", "one"], ["--colour"], []])
def test_wrong_words_are_exit_code_2(command: Any, blend: Path, tmp_path: Path, words: list[str]) -> None:
    given = [*words, "--out", str(tmp_path / "out")] if words else []
    with pytest.raises(SystemExit) as ended:
        command(blend, *given)
    assert ended.value.code == 2


def test_blender_knows_the_command_while_the_extension_is_on(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators.export import command_line

    assert len(command_line._handles) == 1
    command_line.unregister()
    assert not command_line._handles
    command_line.register()
    assert len(command_line._handles) == 1


def test_dev_py_runs_it_in_blender_as_a_module(bpy: ModuleType, blend: Path, tmp_path: Path) -> None:
    """What is installed there is the zip, as on a farm."""
    version = ".".join(map(str, bpy.app.version[:2]))
    words = ["--blender", version, blend.name, "--frames", "1-3", "--format", "pc2,abc", "--out", "out here"]
    done = subprocess.run(
        [sys.executable, str(ROOT / "dev.py"), "bake", *words], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("{"))  # Blender too writes to the output
    assert json.loads(line)["ok"]
    assert sorted(path.suffix for path in (tmp_path / "out here").iterdir()) == [".abc", ".csv", ".json", ".pc2"]
    shutil.rmtree(tmp_path / "out here")
