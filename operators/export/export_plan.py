"""Export animations: check the plan, simulate or take the bake, write each format, and describe the files in a JSON.

Files are written to a temporary folder next to their destination, and moved there when complete: after a cancel the
finished files are kept, and no partial file has a final name.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
from collections.abc import Generator, Iterator
from pathlib import Path

import bpy
import numpy as np

from ...core.background_work import as_share
from ...core.base import DimpleError
from ...core.messages import Message, in_a_row
from ...core.recording import open_point_cache
from ...core.recording.split import split
from ..animate import bake_frames
from ..bridge import cache_files, final_mesh, modifiers, offset, scene_objects
from ..messages import megabytes
from . import clips, formats, sidecar
from .clips import Clip, ExportPlan
from .formats import FORMATS, Size

SIMULATED = 0.5  # share of the progress bar for a simulation
SPARE = 1.05  # factor on the estimated size: space that must be free on the disk

SHEAR = 1e-4  # cosine between two axes below which they count as perpendicular: less is invisible on any object


def finals(plan: ExportPlan) -> list[Path]:
    """Return the paths of all files and folders that an export makes."""
    stems = [cache_files.file_name(obj.name) for obj in plan.objects]
    endings = [*(FORMATS[each].ending for each in plan.formats), ".csv", ".json"]
    return [plan.folder / f"{stem}{ending}" for stem in stems for ending in endings]


def estimate(context: bpy.types.Context, plan: ExportPlan) -> float:
    """Return the approximate size of an export [bytes]; identical frames reduce it."""
    sizes = [size_of(context, obj, plan) for obj in plan.objects]
    return sum(_bytes(plan, each, size) for each in plan.formats for size in sizes)


def _bytes(plan: ExportPlan, each: str, size: Size) -> float:
    kind = FORMATS[each]
    return (plan.last - plan.first + 1) * kind.bytes_of(size) + kind.pictures * size.pictures


def played(obj: bpy.types.Object, plan: ExportPlan) -> Clip | None:
    """Return the bake or recording that an object plays, None if it plays none."""
    for modifier in obj.modifiers:
        if not (modifiers.is_cache(modifier) and modifier.show_viewport):
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
            graph = bpy.context.view_layer.depsgraph  # not updated: a panel being drawn must not evaluate it
            count = len(obj.evaluated_get(graph).data.vertices) if graph and obj.visible_get() else points.shape[1]
            if points.shape[1] != count:
                raise DimpleError(
                    '"{name}" has {count} vertices and its bake {baked}. Bake again, or export with Simulate Again.',
                    name=obj.name, count=count, baked=points.shape[1]
                )  # fmt: skip
            table = path.with_suffix(".csv")
            return Clip(obj=obj, plan=plan, table=table if table.is_file() else None)
    return None


def size_of(context: bpy.types.Context, obj: bpy.types.Object, plan: ExportPlan) -> Size:
    """Return the counts of an object that determine the size of its files."""
    graph = context.view_layer.depsgraph
    mesh = obj.evaluated_get(graph).data if graph else obj.data
    vertices, corners = len(mesh.vertices), len(mesh.loops)
    split_vertices = {"POINT": vertices, "FACE": corners}.get(mesh.normals_domain)
    if split_vertices is None:
        normals = final_mesh.get_points(mesh.corner_normals, corners, "vector")
        split_vertices = len(split(final_mesh.corners_of(mesh), normals[None])[0])
    divided = [each for each in obj.modifiers if hasattr(each, "render_levels") and plan.rendered]
    finer = 4 ** sum(each.render_levels - each.levels for each in divided)
    return Size(finer * vertices, finer * corners, finer * split_vertices, _pictures(obj))


def _pictures(obj: bpy.types.Object) -> int:
    """Return the size of the textures of an object [bytes]."""
    trees = [slot.material.node_tree for slot in obj.material_slots if slot.material and slot.material.node_tree]
    images = {node.image for tree in trees for node in tree.nodes if node.type == "TEX_IMAGE" and node.image}
    files = [Path(bpy.path.abspath(image.filepath, library=image.library)) for image in images if not image.packed_file]
    packed = sum(image.packed_file.size for image in images if image.packed_file)
    return packed + sum(file.stat().st_size for file in files if file.is_file())


def check(plan: ExportPlan) -> None:
    """Check a plan.

    Raises:
        DimpleError: it makes no sense, an object cannot be exported, or files exist already.
    """
    check_choice(plan)
    for obj in plan.objects:
        scene_objects.check(obj)
        scene_objects.check_writable(obj)
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
    """Return whether the axes of an object are not perpendicular at the current frame."""
    axes = np.array(obj.matrix_world)[:3, :3]
    axes = axes / np.linalg.norm(axes, axis=0)
    return bool(np.abs(axes.T @ axes - np.eye(3)).max() > SHEAR)


def check_choice(plan: ExportPlan) -> None:
    """Check the formats and frames of a plan.

    Raises:
        DimpleError: a choice is empty or inconsistent, or this Blender cannot write a format.
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
    """Check that the disk has space for the estimated size.

    Raises:
        DimpleError: it has too little.
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
        messages: receives sentences for the artist.
        written: receives the path of each file once it is complete.

    Raises:
        DimpleError: an object cannot be exported, files exist already, or the disk refuses.
    """
    with contextlib.ExitStack() as files, cache_files.plain_os_errors("The export", "folder"):
        context.view_layer.update()
        check(plan)
        folder = files.enter_context(cache_files.unfinished_folder(plan.folder))
        check_space(context, plan)
        (folder / "simulated").mkdir()
        found = {obj: None if plan.simulate else played(obj, plan) for obj in plan.objects}
        missing = [obj for obj, clip in found.items() if clip is None]
        done = SIMULATED if missing else 0.0
        each_file = (0.99 - done) / (len(plan.objects) * len(plan.formats))  # the rest is for the end
        if missing:
            found |= yield from _simulated(context, plan, missing, folder, messages)
        for obj, clip in found.items():
            _look(context, clip, folder)
            with clips.playing(context, clip):
                described = sidecar.describe(context, clip)
            stem = cache_files.file_name(obj.name)
            if clip.table:
                sidecar.copy_table(clip.table, folder / "table", plan.first, plan.last)
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


def _simulated(
    context: bpy.types.Context, plan: ExportPlan, missing: list[bpy.types.Object], folder: Path, messages: list[str]
) -> Generator[float, None, dict[bpy.types.Object, Clip]]:
    """Simulate objects that play nothing, and return the clips that they are to play."""
    begin = plan.first if plan.begin is None else plan.begin
    bake = bake_frames.BakePlan(  # a bake needs two frames
        objects=missing, first=begin, last=max(plan.last, begin + 1), folder=folder / "simulated"
    )
    bodies = yield from as_share(bake_frames.simulate(context, bake, messages), 0.0, SIMULATED)
    return {
        body.obj: Clip(
            obj=body.obj, plan=plan, plays=(body.path, begin, body.link.cuts), table=body.path.with_suffix(".csv"),
            simulated=sidecar.describe_session(body.session),
        )
        for body in bodies
    }  # fmt: skip


def reserve(context: bpy.types.Context, clip: Clip, each: str, folder: Path) -> None:
    """Make sure that there is space for a file: on a full disk Blender's Alembic exporter terminates Blender.

    Raises:
        OSError: there is too little.
    """
    with clips.playing(context, clip):
        some = size_of(context, clip.obj, clip.plan)
    size = _bytes(clip.plan, each, some) + 64 * some.corners + 2e5
    if hasattr(os, "posix_fallocate"):
        with (folder / "room").open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, int(1.1 * size))
        (folder / "room").unlink()
    elif shutil.disk_usage(folder).free < 1.1 * size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))


def _look(context: bpy.types.Context, clip: Clip, folder: Path) -> None:
    """Give a clip its samples, if a format needs them."""
    if not all(FORMATS[each].played for each in clip.plan.formats):
        normals = "VAT" in clip.plan.formats or clip.plan.key_error > 0
        try:
            clips.look(context, clip, folder, normals=normals)
        except OSError as error:
            raise OSError(error.errno, error.strerror, error.filename or str(folder)) from error


def _commit(part: Path, final: Path, written: list[Path]) -> None:
    """Give a finished file its final name. A folder replaces an existing one as a whole."""
    if final.is_dir() and not final.is_symlink():
        os.replace(final, part.with_name(f"{part.name}.old"))  # deleted with the temporary folder
    os.replace(part, final)
    if final not in written:
        written.append(final)


@contextlib.contextmanager
def _readable_errors(each: str, final: Path) -> Iterator[None]:
    """Make errors say which format could not be written, and where."""
    try:
        yield
    except OSError as error:
        if error.filename:
            raise
        raise OSError(error.errno, error.strerror, str(final)) from error
    except DimpleError as error:
        raise DimpleError("{label}: {error}", label=FORMATS[each].label, error=error) from error
