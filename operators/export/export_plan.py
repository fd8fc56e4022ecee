"""Export animations: check the plan, simulate or take the bake, write each format, and describe the files in a JSON.

Files are written in a temporary folder beside where they go, and go there when they are whole: whoever cancels keeps
what is finished, and nothing half done stands under a final name.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.base import DimpleError
from ...core.messages import Message, in_a_row
from ...core.recording import open_point_cache
from ...core.steps import as_share
from ..animate import bake_frames
from ..bridge import cache_files, offset, scene_objects, stack
from ..messages import megabytes
from . import clips, formats, sidecar
from .clips import Clip
from .formats import FORMATS, Size

SIMULATED = 0.5  # share of the progress bar that a simulation gets
SPARE = 1.05  # of the estimate: room that must be free on the disk

SHEAR = 1e-4  # cosine between two axes: less is not seen on the whole object


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
    simulate: also objects that play a bake or a recording.
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
                    '"{name}" plays {path}, which cannot be read: {error}. Bake again, or export with Simulate '
                    "Again.",
                    name=obj.name, path=path, error=error.strerror
                ) from error  # fmt: skip
            graph = bpy.context.view_layer.depsgraph  # as it is: a panel that is being drawn evaluates nothing
            count = len(obj.evaluated_get(graph).data.vertices) if graph and obj.visible_get() else points.shape[1]
            if points.shape[1] != count:
                raise DimpleError(
                    '"{name}" has {count} vertices and its bake {baked}. Bake again, or export with Simulate Again.',
                    name=obj.name, count=count, baked=points.shape[1]
                )  # fmt: skip
            table = path.with_suffix(".csv")
            return Source(plays=None, table=table if table.is_file() else None)
    return None


def unplayed(plan: ExportPlan) -> list[bpy.types.Object]:
    """Return the objects that must be simulated."""
    return [obj for obj in plan.objects if plan.simulate or played(obj) is None]


def size_of(context: bpy.types.Context, obj: bpy.types.Object, normals: bool) -> Size:
    """Return the numbers of an object on which the length of its files depends."""
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
        scene_objects.check(obj)
        if obj.library:
            raise DimpleError(
                '"{name}" is linked from another file. Make it local first: Object > Relations.', name=obj.name
            )
        if sheared := [FORMATS[each].label for each in plan.formats if each in formats.UNSHEARED and _is_sheared(obj)]:
            raise DimpleError(
                '"{name}" is sheared by the scale of its parents, which {label} cannot hold. Apply that scale, or '
                "choose Alembic or USD.",
                name=obj.name, label=sheared[0],
            )  # fmt: skip
    there = [path.name for path in finals(plan) if os.path.lexists(path)]
    if there and not plan.overwrite:
        which = "{path} is there already." if len(there) == 1 else "{path} and {count} more are there already."
        said = Message(which, path=there[0], count=len(there) - 1)
        raise DimpleError(in_a_row([said, "Choose another folder, or switch Overwrite on."]))


def _is_sheared(obj: bpy.types.Object) -> bool:
    """Tell whether the axes of an object are not at right angles now."""
    axes = np.array(obj.matrix_world)[:3, :3]
    axes = axes / np.linalg.norm(axes, axis=0)
    return bool(np.abs(axes.T @ axes - np.eye(3)).max() > SHEAR)


def check_choice(plan: ExportPlan) -> None:
    """Check the formats and frames of a plan.

    Raises:
        DimpleError: there are none, or this Blender cannot write them.
    """
    if not plan.formats:
        raise DimpleError("No format is chosen. Choose one or more.")
    for kind in (FORMATS[each] for each in plan.formats):
        if kind.exporter and not formats.is_there(kind.exporter):
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
    """Check that the disk has room for the estimated size.

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


def export(context: bpy.types.Context, plan: ExportPlan, messages: list[str], written: list[Path]) -> Iterator[float]:
    """Export; yield the share that is done. Closing the generator cancels; finished files are kept.

    Args:
        messages: gets sentences for the artist.
        written: gets the path of each file once it is whole.

    Raises:
        DimpleError: an object cannot be exported, files are there already, or the disk refuses.
    """
    with contextlib.ExitStack() as files, cache_files.plain_os_errors("The export", "folder"):
        context.view_layer.update()
        check(plan)
        folder = files.enter_context(cache_files.unfinished_folder(plan.folder))
        check_space(context, plan)
        (folder / "simulated").mkdir()
        done = SIMULATED if unplayed(plan) else 0.0
        each_file = (0.99 - done) / (len(plan.objects) * len(plan.formats))  # the rest is for the end
        sources = yield from _sources(context, plan, folder, messages)
        for obj, source in zip(plan.objects, sources, strict=True):
            clip = _clip(context, obj, source, plan, folder)
            with clips.playing(context, obj, clip.plays):
                described = sidecar.describe(context, obj, plan.first, plan.last, source.simulated)
            stem = cache_files.file_name(obj.name)
            if source.table:
                sidecar.copy_table(source.table, folder / "table", plan.first, plan.last)
                _commit(folder / "table", plan.folder / f"{stem}.csv", written)
            for each in plan.formats:
                yield done
                final = plan.folder / f"{stem}{FORMATS[each].ending}"
                part = folder / final.name
                with _readable_errors(each, final):
                    reserve(context, clip, each, folder)
                    for written_share in FORMATS[each].write(context, clip, part):
                        yield done + each_file * written_share
                _commit(part, final, written)
                described["files"][final.name] = sidecar.describe_file(final, each, clip)
                sidecar.write(folder / "sidecar", described)
                _commit(folder / "sidecar", plan.folder / f"{stem}.json", written)
                done += each_file


def _sources(
    context: bpy.types.Context, plan: ExportPlan, folder: Path, messages: list[str]
) -> Generator[float, None, list[Source]]:
    """Return what each object plays, after simulating those that play nothing."""
    found = {obj.session_uid: None if plan.simulate else played(obj) for obj in plan.objects}
    if missing := unplayed(plan):
        begin = plan.first if plan.begin is None else plan.begin
        bake = bake_frames.BakePlan(  # which needs two frames
            objects=missing, first=begin, last=max(plan.last, begin + 1), target="FILES",
            folder=folder / "simulated",
        )
        for body in (yield from as_share(bake_frames.simulate(context, bake, messages), 0.0, SIMULATED)):
            found[body.link.uid] = Source(
                plays=(body.path, begin, body.link.cuts), table=body.path.with_suffix(".csv"),
                simulated=sidecar.describe_session(body.session),
            )  # fmt: skip
    return [source for obj in plan.objects if (source := found[obj.session_uid])]


def reserve(context: bpy.types.Context, clip: Clip, each: str, folder: Path) -> None:
    """Make sure that there is room for a file: where there is none, Blender's Alembic exporter ends Blender.

    Raises:
        OSError: there is not.
    """
    with clips.playing(context, clip.obj, clip.plays):
        some = size_of(context, clip.obj, clip.normals)
    size = (clip.last - clip.first + 1) * FORMATS[each].bytes_of(some) + 64 * some.corners + 2e5
    if hasattr(os, "posix_fallocate"):
        with (folder / "room").open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, int(1.1 * size))
        (folder / "room").unlink()
    elif shutil.disk_usage(folder).free < 1.1 * size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))


def _clip(context: bpy.types.Context, obj: bpy.types.Object, source: Source, plan: ExportPlan, folder: Path) -> Clip:
    samples = np.empty((0, 0, 3), np.float32)
    if not all(FORMATS[each].played for each in plan.formats):
        path = folder / "seen.pc2"
        try:
            samples = clips.seen(context, obj, source.plays, plan.first, plan.last, path)
        except OSError as error:
            raise OSError(error.errno, error.strerror, error.filename or str(path)) from error
    return Clip(
        obj=obj, plays=source.plays, samples=samples, first=plan.first, last=plan.last, step=plan.step,
        key_error=plan.key_error, normals=plan.normals,
    )  # fmt: skip


def _commit(part: Path, final: Path, written: list[Path]) -> None:
    """Give a finished file its final name. A folder replaces the one that is there as a whole."""
    if final.is_dir() and not final.is_symlink():
        os.replace(final, part.with_name(f"{part.name}.old"))  # deleted with the temporary folder
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
