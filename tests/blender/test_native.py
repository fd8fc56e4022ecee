"""The native core comes with the zip, and Blender's own installer puts it where it is found."""

import importlib
import sys
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

from tools.native import PLATFORMS, this_platform


@pytest.fixture
def native(bpy: ModuleType) -> ModuleType:
    return importlib.import_module("bl_ext.user_default.dimple.core.native")


def test_the_native_core_of_the_zip_runs_in_blender(native: ModuleType, extension_zip: Path) -> None:
    name = this_platform()
    with zipfile.ZipFile(extension_zip) as archive:
        wheel = next(entry for entry in archive.namelist() if PLATFORMS[name].tag in entry)
        with archive.open(wheel) as inner, zipfile.ZipFile(inner) as content:
            assert any(entry.endswith(PLATFORMS[name].library) for entry in content.namelist())
    assert native.library()
    assert native.instructions() in ("SSE2", "AVX2", "NEON")


def test_the_library_is_loaded_at_the_first_press_and_not_before(bpy: ModuleType) -> None:
    import subprocess

    code = (
        "import sys, bpy; bpy.ops.preferences.addon_enable(module='bl_ext.user_default.dimple'); "
        "loaded = lambda: any(name.endswith('dimple.core.native') for name in sys.modules); "
        "print('before:', loaded()); bpy.ops.mesh.primitive_cube_add(); "
        "bpy.ops.dimple.poke(depth_mm=1.0, press_s=0.01, hold_s=0.0, release_s=0.0); print('after:', loaded())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert "before: False" in done.stdout and "after: True" in done.stdout, done.stdout + done.stderr
