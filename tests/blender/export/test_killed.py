"""An export or a bake that is killed leaves whole files under their names, and what can be read beside them."""

import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.export.reading import contents, earlier
from tests.point_cache import read_point_cache
from tools.environment import ROOT

# Blender as a module starts with the settings of the factory
ENABLED = (
    "import sys, os, signal, importlib, bpy\n"
    "bpy.ops.preferences.addon_enable(module='bl_ext.user_default.dimple')\n"
    "part = lambda name: importlib.import_module('bl_ext.user_default.dimple.operators.' + name)\n"
)


def killed_at(share: float, blend: Path, out: Path) -> bool:
    """Let a process of its own export, and again killed at a share of the time that took; a first time it plans.

    Returns:
        Whether it was still at work.
    """
    script = ENABLED + (
        "import time\n"
        "share, blend, out = float(sys.argv[1]), *sys.argv[2:]\n"
        "words = ['bake', blend, '--format', 'pc2,abc,usd,stl', '--frames', '1-12', '--overwrite', '--out']\n"
        "for _ in range(2):\n"
        "    began = time.perf_counter()\n"
        "    assert part('command_line').run([*words, out + '_whole']) == 0\n"
        "signal.setitimer(signal.ITIMER_REAL, share * (time.perf_counter() - began))\n"  # which ends it at once
        "assert part('command_line').run([*words, out]) == 0"
    )
    words = [sys.executable, "-c", script, str(share), str(blend), str(out)]
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode in (0, -signal.SIGALRM), done.stderr
    return done.returncode != 0


@pytest.mark.once
@pytest.mark.parametrize("count", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_an_export_that_is_killed_leaves_whole_files_or_those_from_before(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path, count: int
) -> None:
    from bl_ext.user_default.dimple.operators import exporters

    obj, out, chance = pressed(), tmp_path / "out", random.Random(14)
    obj.dimple.enabled = True
    blend = tmp_path / "press.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    before = earlier(out)
    at_work = 0
    for _ in range(count):
        at_work += killed_at(chance.uniform(0.05, 0.9), blend, out)
        now = {name: data for name, data in contents(out).items() if not name.startswith(".dimple-")}
        assert {name for name in before if not name.startswith("Ball_stl")} <= now.keys()
        for name in now.keys() - {name for name, data in before.items() if now.get(name) == data}:
            path = out / name
            if path.suffix == ".pc2":
                assert len(read_point_cache(path)[2]) == 12
            elif path.suffix == ".json":
                assert json.loads(path.read_text())["dimple_animation"] == 1
            elif path.suffix == ".csv":
                assert len(path.read_text().splitlines()) == 13
            else:
                assert exporters.is_whole(path)
    assert at_work > count / 2, "the others were done before"
    bpy.ops.dimple.export_animation(directory=str(out), formats={"PC2"}, frame_start=1, frame_end=2, overwrite=True)
    assert not list(out.glob(".dimple-*")), "the next export clears what is left"


@pytest.fixture
def killed(bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path) -> Path:
    """A folder in which a bake was killed after some frames, in a process of its own."""
    pressed()
    blend, caches = tmp_path / "press.blend", tmp_path / "killed"
    scene.dimple.cache_dir, scene.frame_end = str(caches), 12
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
    script = ENABLED + (
        "bpy.ops.wm.open_mainfile(filepath=sys.argv[1])\n"
        "plan = part('baking').BakePlan(objects=[bpy.data.objects['Ball']], first=1, last=12, target='MESH_CACHE')\n"
        "steps = part('baking').bake(bpy.context, plan, [])\n"
        "frames = (share for share in steps if share > part('working').READY)\n"
        "[next(frames) for _ in range(5)]\n"
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    done = subprocess.run([sys.executable, "-c", script, str(blend)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    return caches


@pytest.mark.once
def test_a_bake_that_is_killed_leaves_a_cache_that_can_be_read_until_the_next(bpy: ModuleType, killed: Path) -> None:
    (folder,) = killed.iterdir()
    (cache,) = folder.glob("*.pc2")
    assert folder.name.startswith(".dimple-") and len(read_point_cache(cache)[2]) == 6
    bpy.ops.dimple.bake(frame_start=1, frame_end=12)
    assert sorted(path.suffix for path in killed.iterdir()) == [".csv", ".pc2"], "the next bake clears what is left"
    whole = read_point_cache(next(killed.glob("*.pc2")))[2]
    assert len(whole) == 12


def test_the_folders_of_those_that_are_at_work_are_left_alone(bpy: ModuleType, tmp_path: Path) -> None:
    from bl_ext.user_default.dimple.operators import unfinished_folder

    with unfinished_folder.opened(tmp_path) as running:
        name = running.name
        elsewhere, killed = tmp_path / ".dimple-another-computer-x1", tmp_path / f"{name}2"
        for folder in (elsewhere, killed):
            folder.mkdir()
            (folder / "lock").touch()
        (running / "half").write_text("half")
        with unfinished_folder.opened(tmp_path) as other:
            assert (running / "half").exists() and elsewhere.exists() and not killed.exists() and other != running
    assert sorted(path.name for path in tmp_path.iterdir()) == [elsewhere.name]


def test_the_lock_of_a_folder_is_deleted_last_so_that_one_half_deleted_is_found_again(
    bpy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import unfinished_folder

    gone, unlink = [], os.unlink

    def noted(path: Any, **options: Any) -> None:
        gone.append(os.path.basename(path))
        unlink(path, **options)

    with unfinished_folder.opened(tmp_path) as folder:
        for number in range(20):
            (folder / f"frame_{number}").touch()
        monkeypatch.setattr(os, "unlink", noted)
    assert len(gone) == 21 and gone[-1] == "lock" and not folder.exists()


@pytest.mark.parametrize("left", [(), ("opening",), ("lock",), ("opening", "half")])
def test_a_folder_is_cleared_wherever_between_making_and_deleting_it_a_kill_came(
    bpy: ModuleType, tmp_path: Path, left: tuple[str, ...]
) -> None:
    from bl_ext.user_default.dimple.operators import unfinished_folder

    with unfinished_folder.opened(tmp_path) as folder:
        killed = tmp_path / f"{folder.name}2"
        killed.mkdir()
        for name in left:
            (killed / name).touch()
        unfinished_folder.clear(tmp_path)
        assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("when", ["mkdtemp", "flock"])
def test_a_folder_that_another_blender_clears_before_it_is_held_is_made_again(
    bpy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    import fcntl
    import tempfile

    from bl_ext.user_default.dimple.operators import unfinished_folder

    module: Any = tempfile if when == "mkdtemp" else fcntl
    real, made = getattr(module, when), []

    def cleared(*given: Any, **named: Any) -> Any:
        """Let the other clear just before the lock is held; it leaves alone whatever is held."""
        if when == "flock" and not made:
            made.append(next(tmp_path.iterdir()))
            unfinished_folder.clear(tmp_path)
        result = real(*given, **named)
        if when == "mkdtemp" and not made:
            made.append(Path(result))
            unfinished_folder.clear(tmp_path)
        return result

    monkeypatch.setattr(module, when, cleared)
    with unfinished_folder.opened(tmp_path) as folder:
        assert made and folder not in made and list(tmp_path.iterdir()) == [folder] and (folder / "lock").exists()
    assert not list(tmp_path.iterdir())
