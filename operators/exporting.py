"""Export animations: simulate or take what plays, write each format, and say in a JSON what is in the files.

Files are written in a folder of their own beside where they go, and take their place when they are whole: whoever
cancels keeps what is finished, and nothing half done stands under a final name.
"""

from __future__ import annotations

import contextlib
import csv
import errno
import os
import shutil
import tempfile
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.base import DimpleError
from ..core.recording import open_point_cache
from . import baking, bridge, bridge_write, output, sidecar
from .formats import FORMATS, Clip

PART = ".dimple-"  # begins the name of the folder of what is not finished
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
    key_error: how far a vertex may be off where shape keys are few, as a share of the object's size; 0 for one a frame.
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
class _Source:
    """What an object plays: a PC2 file, its first frame, the table beside it, and what was simulated, if it was."""

    cache: Path
    first: int
    table: Path | None
    simulated: dict[str, Any] | None = None


def finals(plan: ExportPlan) -> list[Path]:
    """Return the names of everything that an export makes."""
    stems = [output.file_name(obj.name) for obj in plan.objects]
    endings = [*(FORMATS[each].ending for each in plan.formats), ".csv", ".json"]
    return [plan.folder / f"{stem}{ending}" for stem in stems for ending in endings]


def estimate(plan: ExportPlan) -> float:
    """Return about how many bytes an export makes; modifiers that add vertices are not counted."""
    frames, total = plan.last - plan.first + 1, 0.0
    for obj in plan.objects:
        vertices, corners = len(obj.data.vertices), len(obj.data.loops) * plan.normals
        for each in plan.formats:
            keyed = each in ("GLB", "FBX")
            total += FORMATS[each].bytes_of(vertices, -(-frames // plan.step) if keyed else frames, corners)
    return total


def export(
    context: bpy.types.Context, plan: ExportPlan, messages: list[str], written: list[Path]
) -> Iterator[float]:
    """Export; yield the share that is done. Whoever stops asking cancels, and keeps what is finished.

    Args:
        messages: gets sentences for the artist.
        written: gets the path of each file once it is whole.

    Raises:
        DimpleError: an object cannot be exported, files are there already, or the disk refuses.
    """
    with contextlib.ExitStack() as stack, output.plain_os_errors("The export", "folder"):
        _check(plan)
        plan.folder.mkdir(parents=True, exist_ok=True)
        _check_space(plan)
        folder = Path(tempfile.mkdtemp(prefix=PART, dir=plan.folder))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        (folder / "simulated").mkdir()
        sources = yield from _sources(context, plan, folder, messages)
        share, count = 0.5, len(plan.objects) * len(plan.formats)
        for obj, source in zip(plan.objects, sources, strict=True):
            described = sidecar.describe(context, obj, plan.first, plan.last, source.simulated)
            stem = output.file_name(obj.name)
            if source.table:
                _copy_table(source.table, folder / "table", plan)
                _commit(folder / "table", plan.folder / f"{stem}.csv", written)
            _warn(obj, plan, messages)
            for each in plan.formats:
                clip = _clip(obj, source, plan)
                final = plan.folder / f"{stem}{FORMATS[each].ending}"
                part = folder / final.name
                with _readable_errors(each, final):
                    reserve(context, clip, each, folder)
                    for done in FORMATS[each].write(context, clip, part):
                        yield share + 0.49 * done / count
                _commit(part, final, written)
                described["files"][final.name] = sidecar.describe_file(final, each, clip)
                sidecar.write(folder / "sidecar", described)
                _commit(folder / "sidecar", plan.folder / f"{stem}.json", written)
                share += 0.49 / count


def _check(plan: ExportPlan) -> None:
    if plan.last < plan.first:
        raise DimpleError(f"The last frame ({plan.last}) must not come before the first ({plan.first}).")
    if plan.begin is not None and plan.begin > plan.first:
        raise DimpleError(f"The simulation begins at frame {plan.begin}, after the first ({plan.first}).")
    if not plan.formats:
        raise DimpleError("No format is chosen. Choose one or more.")
    for obj in plan.objects:
        bridge.check(obj)
        if obj.library:
            raise DimpleError(f'"{obj.name}" is linked from another file. Make it local first: Object > Relations.')
    there = [path.name for path in finals(plan) if os.path.lexists(path)]
    if there and not plan.overwrite:
        more = f" and {len(there) - 1} more" if len(there) > 1 else ""
        raise DimpleError(f"{there[0]}{more} is there already. Choose another folder, or switch Overwrite on.")


def _check_space(plan: ExportPlan) -> None:
    needed, free = SPARE * estimate(plan), shutil.disk_usage(plan.folder).free
    if needed > free:
        raise DimpleError(
            f"The export needs about {needed / 1e6:.0f} MB, and {plan.folder} has {free / 1e6:.0f} MB left. "
            "Choose another folder, fewer frames or fewer formats."
        )


def _sources(
    context: bpy.types.Context, plan: ExportPlan, folder: Path, messages: list[str]
) -> Generator[float, None, list[_Source]]:
    """Return what each object plays, after simulating those that play nothing."""
    found = {obj.session_uid: None if plan.simulate else _played(obj) for obj in plan.objects}
    missing = [obj for obj in plan.objects if found[obj.session_uid] is None]
    if missing:
        begin = plan.first if plan.begin is None else plan.begin
        bake = baking.BakePlan(  # which needs two frames
            objects=missing, first=begin, last=max(plan.last, begin + 1), target="FILES",
            folder=folder / "simulated",
        )
        steps = baking.simulate(context, bake, messages)
        bodies = yield from _scaled(steps, 0.5)
        for body in bodies:
            found[body.link.uid] = _Source(
                cache=body.path, first=begin, table=body.path.with_suffix(".csv"),
                simulated=sidecar.describe_session(body.session),
            )  # fmt: skip
    return [source for obj in plan.objects if (source := found[obj.session_uid])]


def _scaled(steps: Generator[float, None, Any], share: float) -> Generator[float, None, Any]:
    try:
        while True:
            yield share * next(steps)
    except StopIteration as stop:
        return stop.value
    finally:
        steps.close()


def _played(obj: bpy.types.Object) -> _Source | None:
    """Return the bake or recording that an object plays, None where it plays none."""
    for modifier in obj.modifiers:
        if bridge_write.is_cache(modifier) and modifier.show_viewport and modifier.cache_format == "PC2":
            path = Path(bpy.path.abspath(modifier.filepath))
            try:
                start, points = open_point_cache(path)
            except OSError as error:
                raise DimpleError(
                    f'"{obj.name}" plays {path}, which cannot be read: {error.strerror}. '
                    "Bake again, or export with Simulate Anew."
                ) from error
            if points.shape[1] != len(obj.data.vertices):
                raise DimpleError(
                    f'"{obj.name}" has {len(obj.data.vertices)} vertices and its bake {points.shape[1]}. '
                    "Bake again, or export with Simulate Anew."
                )
            table = path.with_suffix(".csv")
            return _Source(cache=path, first=round(modifier.frame_start), table=table if table.is_file() else None)
    return None


def reserve(context: bpy.types.Context, clip: Clip, each: str, folder: Path) -> None:
    """Make sure that there is room for a file: where there is none, Blender's Alembic exporter ends Blender.

    Raises:
        OSError: there is not.
    """
    seen = clip.obj.evaluated_get(context.evaluated_depsgraph_get()).data
    vertices = max(len(seen.vertices), len(clip.obj.data.vertices))
    corners = max(len(seen.loops), len(clip.obj.data.loops))
    size = FORMATS[each].bytes_of(vertices, len(clip.samples), corners * clip.normals) + 64 * corners + 2e5
    if hasattr(os, "posix_fallocate"):
        with (folder / "room").open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, int(1.1 * size))
        (folder / "room").unlink()
    elif shutil.disk_usage(folder).free < 1.1 * size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))


def _clip(obj: bpy.types.Object, source: _Source, plan: ExportPlan) -> Clip:
    _, points = open_point_cache(source.cache)
    begin, end = plan.first - source.first, plan.last - source.first + 1
    if begin < 0 or end > len(points):  # before and after a recording its first and last shape stay
        points = points[np.clip(np.arange(begin, end), 0, len(points) - 1)]
        begin, end = 0, len(points)
    return Clip(
        obj=obj, cache=source.cache, cache_first=source.first, samples=points[begin:end], first=plan.first,
        last=plan.last, step=plan.step, key_error=plan.key_error, normals=plan.normals,
    )  # fmt: skip


def _copy_table(table: Path, path: Path, plan: ExportPlan) -> None:
    """Write the lines of a table that are within the frames."""
    with table.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    kept = [row for row in rows if row and plan.first <= float(row[0]) <= plan.last]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *kept])


def _warn(obj: bpy.types.Object, plan: ExportPlan, messages: list[str]) -> None:
    others = [modifier.name for modifier in obj.modifiers if not bridge_write.is_cache(modifier)]
    labels = [FORMATS[each].label for each in plan.formats if each in ("PC2", "MDD", "GLB", "FBX", "VAT")]
    if others and labels:
        messages.append(
            f'"{obj.name}": {", ".join(labels)} holds the mesh before its modifiers ({", ".join(others)}).'
        )


def _commit(part: Path, final: Path, written: list[Path]) -> None:
    """Let what is whole take its name. A folder takes the place of the one that is there as a whole."""
    if final.is_dir() and not final.is_symlink():
        os.replace(final, part.with_name(f"{part.name}.old"))  # goes with the temporary folder
    os.replace(part, final)
    if final not in written:
        written.append(final)


@contextlib.contextmanager
def _readable_errors(each: str, final: Path) -> Iterator[None]:
    """Let an error say which format could not be written, and where."""
    try:
        yield
    except OSError as error:
        if error.filename:
            raise
        raise OSError(error.errno, error.strerror, str(final)) from error
    except DimpleError as error:
        raise DimpleError(f"{FORMATS[each].label}: {error}") from error
