"""Measure the cost of enabling the extension in Blender: `python3 dev.py bench --enabling`."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from tools.environment import ROOT
from tools.extension import build_zip

TIMES = 9  # processes of their own; the first also compiles the files of the extension
INSTALL = "bpy.ops.extensions.package_install_files(filepath={!r}, repo='user_default', enable_on_install=False)"
ENABLE = (
    "started = time.process_time()\n"
    "assert addon_utils.enable('bl_ext.user_default.dimple') is not None\n"
    "print('took', time.process_time() - started)"
)


def in_blender(code: str, profile: str) -> str:
    """Run code in a fresh Blender with this profile, and return what it printed."""
    environment = {**os.environ, "BLENDER_USER_RESOURCES": profile}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # Blender keeps what it compiled
    # without leaving by the front door: Blender's own clearing up is not measured and may take its time
    whole = f"import os, time, bpy, addon_utils\n{code}\nprint('in', bpy.app.version_string, flush=True)\nos._exit(0)"
    return subprocess.run(
        [sys.executable, "-c", whole], env=environment, capture_output=True, text=True, timeout=300, check=True
    ).stdout


def main() -> int:
    path = build_zip(sys.executable, Path(ROOT) / "build")
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        version = in_blender(INSTALL.format(str(path)), profile).rpartition("in ")[2].strip()
        outputs = [in_blender(ENABLE, profile) for _ in range(TIMES)]
    first, *others = [1000 * float(text.partition("took ")[2].split()[0]) for text in outputs]
    low, middle, high = min(others), statistics.median(others), max(others)
    print(f"Blender {version}: enabling takes {middle:.0f} ms of processor time ({low:.0f} to {high:.0f}),")
    print(f"{first:.0f} ms the first time after installation, when Python compiles the files")
    return 0
