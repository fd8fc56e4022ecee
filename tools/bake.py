"""Run `blender --command dimple bake` with Blender as a module: `bake.py --zip DIMPLE.zip OPTIONS`."""

from __future__ import annotations

import importlib
import sys


def main(words: list[str]) -> int:
    import bpy

    option, path, *rest = words
    assert option == "--zip"
    bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=True)
    command_line = importlib.import_module("bl_ext.user_default.dimple.operators.export.command_line")
    return int(command_line.run(["bake", *rest]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
