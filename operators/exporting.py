"""Export animations: simulate or take what plays, write each format, and say in a JSON what is in the files.

Files are written in a folder of their own beside where they go, and go there when they are whole: whoever cancels keeps
what is finished, and nothing half done stands under a final name.
"""

from __future__ import annotations

import contextlib
import csv
import errno
import os
import shutil
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.base import DimpleError
from . import baking, cache_files, export_time, sidecar, stage, unfinished_folder
from .clip import Clip
from .export_plan import ExportPlan, Source, check, check_space, played, size_of, unplayed
from .formats import FORMATS


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
    with contextlib.ExitStack() as stack, cache_files.plain_os_errors("The export", "folder"):
        context.view_layer.update()
        check(plan)
        folder = stack.enter_context(unfinished_folder.opened(plan.folder))
        check_space(context, plan)
        (folder / "simulated").mkdir()
        first, *parts = _shares(plan)
        sources = yield from _sources(context, plan, folder, messages, first)
        done = first
        for obj, source in zip(plan.objects, sources, strict=True):
            clip = _clip(context, obj, source, plan, folder)
            with stage.playing(context, obj, clip.plays):
                described = sidecar.describe(context, obj, plan.first, plan.last, source.simulated)
            stem = cache_files.file_name(obj.name)
            if source.table:
                _copy_table(source.table, folder / "table", plan)
                _commit(folder / "table", plan.folder / f"{stem}.csv", written)
            for each in plan.formats:
                yield done
                part_of_all = parts.pop(0)
                final = plan.folder / f"{stem}{FORMATS[each].ending}"
                part = folder / final.name
                with _readable_errors(each, final):
                    reserve(context, clip, each, folder)
                    for written_share in FORMATS[each].write(context, clip, part):
                        yield done + part_of_all * written_share
                _commit(part, final, written)
                described["files"][final.name] = sidecar.describe_file(final, each, clip)
                sidecar.write(folder / "sidecar", described)
                _commit(folder / "sidecar", plan.folder / f"{stem}.json", written)
                done += part_of_all


def _shares(plan: ExportPlan) -> list[float]:
    """Return which share of the time the simulation takes, and each file after it; a rest is left for the end."""
    simulated, count = unplayed(plan), len(plan.objects) * len(plan.formats)
    first, then = export_time.parts(plan, simulated) or ([float(bool(simulated))], [1 / count] * count)
    return [0.99 * part / (sum(first) + sum(then)) for part in (sum(first), *then)]


def _sources(
    context: bpy.types.Context, plan: ExportPlan, folder: Path, messages: list[str], share: float
) -> Generator[float, None, list[Source]]:
    """Return what each object plays, after simulating those that play nothing, a share of the whole."""
    found = {obj.session_uid: None if plan.simulate else played(obj) for obj in plan.objects}
    missing = [obj for obj in plan.objects if found[obj.session_uid] is None]
    if missing:
        begin = plan.first if plan.begin is None else plan.begin
        bake = baking.BakePlan(  # which needs two frames
            objects=missing, first=begin, last=max(plan.last, begin + 1), target="FILES",
            folder=folder / "simulated",
        )
        steps = baking.simulate(context, bake, messages)
        bodies = yield from _scaled(steps, share)
        for body in bodies:
            found[body.link.uid] = Source(
                plays=(body.path, begin, body.link.cuts), table=body.path.with_suffix(".csv"),
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


def reserve(context: bpy.types.Context, clip: Clip, each: str, folder: Path) -> None:
    """Make sure that there is room for a file: where there is none, Blender's Alembic exporter ends Blender.

    Raises:
        OSError: there is not.
    """
    with stage.playing(context, clip.obj, clip.plays):
        some = size_of(context, clip.obj, clip.normals)
    size = (clip.last - clip.first + 1) * FORMATS[each].bytes_of(some) + 64 * some.corners + 2e5
    if hasattr(os, "posix_fallocate"):
        with (folder / "room").open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, int(1.1 * size))
        (folder / "room").unlink()
    elif shutil.disk_usage(folder).free < 1.1 * size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))


def _clip(
    context: bpy.types.Context, obj: bpy.types.Object, source: Source, plan: ExportPlan, folder: Path
) -> Clip:
    samples = np.empty((0, 0, 3), np.float32)
    if not all(FORMATS[each].played for each in plan.formats):
        path = folder / "seen.pc2"
        try:
            samples = stage.seen(context, obj, source.plays, plan.first, plan.last, path)
        except OSError as error:
            raise OSError(error.errno, error.strerror, error.filename or str(path)) from error
    return Clip(
        obj=obj, plays=source.plays, samples=samples, first=plan.first, last=plan.last, step=plan.step,
        key_error=plan.key_error, normals=plan.normals,
    )  # fmt: skip


def _copy_table(table: Path, path: Path, plan: ExportPlan) -> None:
    """Write the lines of a table that are within the frames."""
    with table.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    kept = [row for row in rows if row and plan.first <= float(row[0]) <= plan.last]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *kept])


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
        raise DimpleError("{label}: {error}", label=FORMATS[each].label, error=error) from error
