"""Build the zip that Blender installs, with Blender's own tool."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
from pathlib import Path

from . import native
from .environment import PIP, ROOT, WHEEL_PINS, Stop, alone, require, say

WHEELS = ROOT / "wheels"
EXTENSION_TOOL = "bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py"  # in site-packages


def build_zip(python: str | Path, folder: Path, *, split: bool = False) -> Path:
    """Validate the extension and build its zip with Blender's own tool, in plain Python.

    Args:
        python: the Python of an environment.
        folder: the zip is written here.
        split: write a smaller zip for each platform too.

    Returns:
        The path of the zip for all platforms.

    Raises:
        Stop: Blender's tool refused the extension.
    """
    with alone():
        shipped_wheels(python)
        native.provide_wheels(python)
    home = Path(python).parent.parent
    libraries = [*home.glob("lib/python*/site-packages"), home / "Lib" / "site-packages"]
    tool = next(path for library in libraries for path in library.glob(EXTENSION_TOOL))
    manifest = (ROOT / "blender_manifest.toml").read_text()
    (version,) = re.findall('^version = "(.+)"', manifest, re.MULTILINE)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"dimple-{version}.zip"
    steps: list[list[str | Path]] = [
        ["validate", ROOT],
        ["build", "--source-dir", ROOT, "--output-filepath", path],
        ["validate", path],
    ]
    if split:
        steps.append(["build", "--split-platforms", "--source-dir", ROOT, "--output-dir", folder])
    for step in steps:
        answer = subprocess.run([python, tool, *step], capture_output=True, text=True)
        if answer.returncode != 0:
            raise Stop(f"Blender's extension tool refused:\n{answer.stdout}{answer.stderr}")
    return path


def shipped_wheels(python: str | Path) -> list[Path]:
    """Return the wheels of other projects that the extension ships, downloaded again if they differ from the pins."""
    pinned = set(re.findall(r"--hash=sha256:(\w+)", WHEEL_PINS.read_text()))
    if {hashlib.sha256(wheel.read_bytes()).hexdigest() for wheel in foreign_wheels()} != pinned:
        say("downloading the wheels that the extension ships")
        shutil.rmtree(WHEELS, ignore_errors=True)
        download = [python, *PIP, "download", "-q", "--no-deps", "--only-binary", ":all:"]
        require([*download, "-d", WHEELS, "-r", WHEEL_PINS], "The wheels could not be downloaded.")
    return foreign_wheels()


def foreign_wheels() -> list[Path]:
    return sorted(set(WHEELS.glob("*.whl")) - set(WHEELS.glob(f"{native.PACKAGE}-*.whl")))
