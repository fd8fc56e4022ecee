"""Blender's own exporters: asked with the options that a version has, and looked at afterwards."""

from __future__ import annotations

import operator
from pathlib import Path

import bpy

from ..core.base import DimpleError


def is_there(name: str) -> bool:
    """Tell whether this Blender has an exporter: it may be built without, or the add-on be switched off."""
    place, _, verb = name.partition(".")
    return verb in dir(getattr(bpy.ops, place))


def ask(name: str, *, filepath: str, **options: object) -> None:
    """Ask an exporter of Blender's by the name of its operator, with the options that this Blender has.

    Raises:
        DimpleError: it refused, or wrote nothing.
    """
    export = operator.attrgetter(name)(bpy.ops)
    known = export.get_rna_type().properties.keys()
    try:
        result = export(filepath=filepath, **{name: value for name, value in options.items() if name in known})
    except RuntimeError as error:
        raise DimpleError(
            "Blender's exporter failed at {filepath}: {why}", filepath=filepath, why=_last_line(str(error))
        ) from error
    if "FINISHED" not in result or not is_whole(Path(filepath)):
        raise DimpleError(
            "Blender's exporter could not finish {filepath}. Is the disk full, or the folder read-only?",
            filepath=filepath,
        )


def _last_line(text: str) -> str:
    """Return what an error says, without where in Blender it was raised."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith((" ", "Location:"))]
    return lines[-1].removeprefix("Error: ") if lines else text


def is_whole(path: Path) -> bool:
    """Tell whether a file ends where it says it does; some exporters do not notice that a disk is full."""
    if not path.is_file():
        return False
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(4096)
    if path.suffix == ".abc":  # set when an Ogawa archive is closed
        return head[:6] == b"Ogawa\xff"
    if path.suffix == ".usdc":  # the table of contents is written last
        return len(head) >= 24 and 24 <= int.from_bytes(head[16:24], "little") < size
    if path.suffix == ".glb":
        return int.from_bytes(head[8:12], "little") == size
    if path.suffix == ".stl":
        return size == 84 + 50 * int.from_bytes(head[80:84], "little")
    if path.suffix == ".ply":
        text, _, _ = head.partition(b"end_header\n")
        vertices, triangles = (int(text.split(b"element " + each)[1].split()[0]) for each in (b"vertex", b"face"))
        return size == len(text) + 11 + 4 * text.count(b"property float") * vertices + 13 * triangles
    return size > 0
