"""What is to be exported: checked before anything is written, and how large it will be."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ..core.base import DimpleError
from ..core.messages import Message, in_a_row
from ..core.recording import open_point_cache
from . import bridge, cache_files, exporters, offset, stack
from .formats import FORMATS, Size
from .messages import megabytes

SPARE = 1.05  # of the estimate: room that must be free on the disk


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportPlan:
    """What to export.

    objects: the bodies.
    formats: keys of `formats.FORMATS`, in the order in which they are written.
    folder: where the files go; it is made.
    first, last: frames.
    begin: frame at which the simulation begins at rest; None is the first.
    step: frames from one shape key to the next.
    key_error: how far a vertex may be off where shape keys are few, as a share of the object's size; 0 for a shape key
        every `step` frames.
    simulate: simulate anew also what plays a bake or a recording.
    overwrite: files that are there.
    normals: write how the surface is shaded.
    """

    objects: Sequence[bpy.types.Object]
    formats: Sequence[str]
    folder: Path
    first: int
    last: int
    begin: int | None = None
    step: int = 1
    key_error: float = 0.0
    simulate: bool = False
    overwrite: bool = False
    normals: bool = True


@dataclass(slots=True, kw_only=True, eq=False)
class Source:
    """What an object plays, and the table beside it.

    plays: what it is to play, as in `Clip`; None where it plays already.
    simulated: how, where it was for this.
    """

    plays: tuple[Path, float, int] | None
    table: Path | None
    simulated: dict[str, Any] | None = None


def finals(plan: ExportPlan) -> list[Path]:
    """Return the names of everything that an export makes."""
    stems = [cache_files.file_name(obj.name) for obj in plan.objects]
    endings = [*(FORMATS[each].ending for each in plan.formats), ".csv", ".json"]
    return [plan.folder / f"{stem}{ending}" for stem in stems for ending in endings]


def estimate(context: bpy.types.Context, plan: ExportPlan) -> float:
    """Return about how many bytes an export makes."""
    frames, total = plan.last - plan.first + 1, 0.0
    for obj in plan.objects:
        for each in plan.formats:
            kind = FORMATS[each]
            count = -(-frames // plan.step) if kind.keyed and not plan.key_error else frames
            total += count * kind.bytes_of(size_of(context, obj, plan.normals))
    return total


def played(obj: bpy.types.Object) -> Source | None:
    """Return the bake or recording that an object plays, None where it plays none."""
    for modifier in obj.modifiers:
        if not (stack.is_cache(modifier) and modifier.show_viewport):
            continue
        for path, _ in offset.files(modifier)[:1]:
            try:
                _, points = open_point_cache(path)
            except OSError as error:
                raise DimpleError(
                    '"{name}" plays {path}, which cannot be read: {error}. Bake again, or export with Simulate Anew.',
                    name=obj.name, path=path, error=error.strerror
                ) from error  # fmt: skip
            graph = bpy.context.view_layer.depsgraph  # as it is: a panel that is being drawn evaluates nothing
            count = len(obj.evaluated_get(graph).data.vertices) if graph and obj.visible_get() else points.shape[1]
            if points.shape[1] != count:
                raise DimpleError(
                    '"{name}" has {count} vertices and its bake {baked}. Bake again, or export with Simulate Anew.',
                    name=obj.name, count=count, baked=points.shape[1]
                )  # fmt: skip
            table = path.with_suffix(".csv")
            return Source(plays=None, table=table if table.is_file() else None)
    return None


def unplayed(plan: ExportPlan) -> list[bpy.types.Object]:
    """Return the objects that must be simulated."""
    return [obj for obj in plan.objects if plan.simulate or played(obj) is None]


def size_of(context: bpy.types.Context, obj: bpy.types.Object, normals: bool) -> Size:
    """Return what the length of the files of an object depends on."""
    graph = context.view_layer.depsgraph
    mesh = obj.evaluated_get(graph).data if graph else obj.data
    corners = len(mesh.loops)
    sharp = mesh.normals_domain != "POINT"
    return Size(len(mesh.vertices), corners, corners - 2 * len(mesh.polygons), normals, sharp)


def check(plan: ExportPlan) -> None:
    """Check a plan.

    Raises:
        DimpleError: it makes no sense, an object cannot be exported, or files are there already.
    """
    check_choice(plan)
    for obj in plan.objects:
        bridge.check(obj)
        if obj.library:
            raise DimpleError(
                '"{name}" is linked from another file. Make it local first: Object > Relations.', name=obj.name
            )
    there = [path.name for path in finals(plan) if os.path.lexists(path)]
    if there and not plan.overwrite:
        which = "{path} is there already." if len(there) == 1 else "{path} and {count} more are there already."
        said = Message(which, path=there[0], count=len(there) - 1)
        raise DimpleError(in_a_row([said, "Choose another folder, or switch Overwrite on."]))


def check_choice(plan: ExportPlan) -> None:
    """Check the formats and frames of a plan.

    Raises:
        DimpleError: there are none, or this Blender cannot write them.
    """
    if not plan.formats:
        raise DimpleError("No format is chosen. Choose one or more.")
    for kind in (FORMATS[each] for each in plan.formats):
        if kind.exporter and not exporters.is_there(kind.exporter):
            raise DimpleError(
                "This Blender cannot write {label}: it was built without that exporter, or its add-on is switched "
                "off. Choose another format.",
                label=kind.label,
            )
    if plan.last < plan.first:
        raise DimpleError(
            "The last frame ({last}) must not come before the first ({first}).", last=plan.last, first=plan.first
        )
    if plan.begin is not None and plan.begin > plan.first:
        raise DimpleError(
            "The simulation begins at frame {begin}, after the first ({first}).", begin=plan.begin, first=plan.first
        )


def check_space(context: bpy.types.Context, plan: ExportPlan) -> None:
    """Check that the disk has room for what is estimated.

    Raises:
        DimpleError: it has not.
    """
    needed, free = SPARE * estimate(context, plan), shutil.disk_usage(plan.folder).free
    if needed > free:
        raise DimpleError(
            "The export needs about {needed} MB, and {folder} has {free:.1f} MB left. Choose another folder, fewer "
            "frames or fewer formats.",
            needed=megabytes(needed), folder=plan.folder, free=free / 1e6
        )  # fmt: skip
