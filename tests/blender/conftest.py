"""Blender as a module, in a profile of its own, with the built zip installed as an artist would.

What Blender does not ship is hidden from the extension, though this environment holds it.
"""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

PROFILE = tempfile.mkdtemp(prefix="dimple-profile-")
atexit.register(shutil.rmtree, PROFILE, ignore_errors=True)
os.environ["BLENDER_USER_RESOURCES"] = PROFILE  # read when bpy is imported, so before any test module
for name in ("matplotlib", "networkx", "PIL", "scipy", "serial", "trimesh"):
    sys.modules[name] = None  # type: ignore[assignment]


@pytest.fixture(scope="session")
def bpy(extension_zip: Path) -> ModuleType:
    """Blender with Dimple installed from the zip and enabled."""
    import bpy

    for name in ("serial", "trimesh"):
        del sys.modules[name]  # these come with the zip
    result = bpy.ops.extensions.package_install_files(
        filepath=str(extension_zip), repo="user_default", enable_on_install=True
    )
    assert result == {"FINISHED"}
    assert "bl_ext.user_default.dimple" in bpy.context.preferences.addons, "the extension was not enabled"
    return bpy


@pytest.fixture
def empty_file(bpy: ModuleType) -> Iterator[ModuleType]:
    """Blender with a file that holds nothing but a scene; Dimple stays enabled."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    yield bpy
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
