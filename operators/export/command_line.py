"""`blender --command dimple bake FILE.blend ...`: export without a window, for farms and pipelines.

It prints one line of JSON, which --json writes to a file too. Exit codes: 0 all is written; 1 something is wrong, and
the JSON says what; 2 the words of the command are.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy

from ...core.errors import DimpleError
from .export_dialog import EXPORTS

COMMAND = "dimple"
NAMES = {"abc": "ALEMBIC", "usd": "USD", "glb": "GLB", "fbx": "FBX", "pc2": "PC2", "vat": "VAT"}
ENDED, WRONG = 0, 1


def run(words: list[str]) -> int:
    """Run a command; argparse ends the process with exit code 2 if the arguments are wrong."""
    options = parser().parse_args(words)
    started, written, messages = time.perf_counter(), [], []  # type: ignore[var-annotated]
    result: dict[str, Any] = {"ok": False, "error": None, "file": str(options.file)}
    try:
        plan = _open(options)
        result |= {"objects": [obj.name for obj in plan.objects], "frames": [plan.first, plan.last]}
        _export(plan, messages, written)
        result["ok"] = True
    except (DimpleError, OSError) as error:
        result["error"] = str(error)
    result |= {
        "written": [str(path) for path in written], "messages": messages,
        "seconds": round(time.perf_counter() - started, 3),
    }  # fmt: skip
    line = json.dumps(result, ensure_ascii=False)
    if options.json:
        options.json.write_text(line + "\n", encoding="utf-8")
    print(line, flush=True)
    return ENDED if result["ok"] else WRONG


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's arguments."""
    whole = argparse.ArgumentParser(prog=f"blender --command {COMMAND}", description=(__doc__ or "").split("\n\n")[1])
    bake = whole.add_subparsers(metavar="COMMAND", required=True).add_parser(
        "bake", help="export the bodies of a .blend file; those without a bake are simulated", allow_abbrev=False
    )
    bake.add_argument("file", type=Path, metavar="FILE.blend")
    bake.add_argument("--object", action="append", metavar="NAME", help="may be repeated; default: every body")
    bake.add_argument("--frames", type=_frames, metavar="FIRST-LAST", help="default: those of the scene")
    bake.add_argument("--format", type=_formats, default=["ALEMBIC"], metavar="abc,usd,glb", help=", ".join(NAMES))
    bake.add_argument("--out", type=Path, required=True, metavar="DIR", help="output folder, created if needed")
    bake.add_argument("--key-error", type=float, default=0.0, metavar="PERCENT", help="glTF, FBX: fewer shape keys")
    bake.add_argument("--rendered", action="store_true", help="modifiers as in a render, not as in the viewport")
    bake.add_argument("--overwrite", action="store_true", help="replace existing files")
    bake.add_argument("--json", type=Path, metavar="FILE", help="also write the summary to this file")
    return whole


def _frames(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(-?\d+)(?:-(-?\d+))?", text)
    if not found:
        raise argparse.ArgumentTypeError(f"{text!r} is no range of frames such as 1-250")
    return int(found[1]), int(found[2] or found[1])


def _formats(text: str) -> list[str]:
    names = [each for each in re.split(r"[,\s]+", text.lower()) if each]
    unknown = [each for each in names if each not in NAMES]
    if unknown or not names:
        raise argparse.ArgumentTypeError(f"{', '.join(unknown) or text!r} is no format; there are {', '.join(NAMES)}")
    wanted = {NAMES[each] for each in names}
    return [key for key, *_ in EXPORTS if key in wanted]


def _open(options: argparse.Namespace) -> Any:
    from . import export_plan

    if not options.file.is_file():
        raise DimpleError(f"There is no file {options.file}.")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(options.file.resolve()))
    except RuntimeError as error:
        raise DimpleError(f"Blender cannot open {options.file}: {str(error).strip()}") from error
    scene = bpy.context.scene
    first, last = options.frames or (scene.frame_start, scene.frame_end)
    return export_plan.ExportPlan(
        objects=_bodies(scene, options.object),
        formats=options.format,
        folder=options.out.resolve(),
        first=first,
        last=last,
        key_error=max(options.key_error, 0.0) / 100,
        overwrite=options.overwrite,
        rendered=options.rendered,
    )


def _bodies(scene: bpy.types.Scene, names: Sequence[str] | None) -> list[bpy.types.Object]:
    bodies = [obj for obj in scene.objects if obj.type == "MESH" and obj.dimple.enabled]
    if names is None:
        if not bodies:
            raise DimpleError("No object of the scene is a Dimple body. Name one with --object.")
        return bodies
    missing = [name for name in names if name not in scene.objects]
    if missing:
        there = ", ".join(obj.name for obj in bodies) or "none"
        raise DimpleError(f'The scene has no object "{missing[0]}". Its Dimple bodies: {there}.')
    return [scene.objects[name] for name in dict.fromkeys(names)]


def _export(plan: Any, messages: list[str], written: list[Path]) -> None:
    from . import export_plan

    shown = -1
    for share in export_plan.export(bpy.context, plan, messages, written):
        if int(20 * share) > shown:
            shown = int(20 * share)
            print(f"dimple: {share:.0%}", file=sys.stderr, flush=True)


_handles: list[object] = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command(COMMAND, run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
