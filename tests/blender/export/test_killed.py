"""An export or a bake that is killed leaves whole files under their names, and what can be read beside them."""

import json
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.export.reading import contents, earlier, is_whole
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
        "words = ['bake', blend, '--format', 'pc2,abc,usd,vat', '--frames', '1-12', '--overwrite', '--out']\n"
        "for _ in range(2):\n"
        "    began = time.perf_counter()\n"
        "    assert part('export.command_line').run([*words, out + '_whole']) == 0\n"
        "signal.setitimer(signal.ITIMER_REAL, share * (time.perf_counter() - began))\n"  # which ends it at once
        "assert part('export.command_line').run([*words, out]) == 0"
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
    obj, out, chance = pressed(), tmp_path / "out", random.Random(14)
    obj.dimple.enabled = True
    blend = tmp_path / "press.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    before = earlier(out)
    at_work = 0
    for _ in range(count):
        at_work += killed_at(chance.uniform(0.05, 0.9), blend, out)
        now = {name: data for name, data in contents(out).items() if not name.startswith(".dimple-")}
        assert {name for name in before if not name.startswith(("Ball_usd", "Ball_vat"))} <= now.keys()
        for name in now.keys() - {name for name, data in before.items() if now.get(name) == data}:
            path = out / name
            if path.suffix == ".pc2":
                assert len(read_point_cache(path)[2]) == 12
            elif path.suffix == ".json":
                assert json.loads(path.read_text())["dimple_animation"] == 1
            elif path.suffix == ".csv":
                assert len(path.read_text().splitlines()) == 13
            else:
                assert is_whole(path)
    assert at_work > count / 2, "the others were done before"


@pytest.fixture
def killed(bpy: ModuleType, scene: Any, pressed: Callable[..., Any], tmp_path: Path) -> Path:
    """A folder in which a bake was killed after some frames, in a process of its own."""
    pressed()
    blend, caches = tmp_path / "press.blend", tmp_path / "killed"
    scene.dimple.cache_dir, scene.frame_end = str(caches), 12
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
    script = ENABLED + (
        "bpy.ops.wm.open_mainfile(filepath=sys.argv[1])\n"
        "new = part('animate.bake_to_files').BakePlan\n"
        "plan = new(objects=[bpy.data.objects['Ball']], first=1, last=12)\n"
        "steps = part('animate.bake_to_files').bake(bpy.context, plan, [])\n"
        "frames = (share for share in steps if share > part('press.progress').READY)\n"
        "[next(frames) for _ in range(5)]\n"
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    done = subprocess.run([sys.executable, "-c", script, str(blend)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    return caches


@pytest.mark.once
def test_a_bake_that_is_killed_leaves_a_cache_that_can_be_read(bpy: ModuleType, killed: Path) -> None:
    (folder,) = killed.iterdir()
    (cache,) = folder.glob("*.pc2")
    assert folder.name.startswith(".dimple-") and len(read_point_cache(cache)[2]) == 6
    bpy.ops.dimple.bake(frame_start=1, frame_end=12)
    assert sorted(path.suffix for path in killed.iterdir() if path.is_file()) == [".csv", ".pc2"]
    whole = read_point_cache(next(killed.glob("*.pc2")))[2]
    assert len(whole) == 12
