"""Export animations: check the plan, simulate or take the bake, write each format, and describe the files in a JSON.

Files are written to a temporary folder next to their destination, and moved there when complete: after a cancel the
finished files are kept, and no partial file has a final name.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import shutil
import tempfile
from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ...core.background_work import as_share
from ...core.base import DimpleError
from ...core.message import Message, in_a_row
from ...core.recording import open_point_cache
from ...core.recording.split import split
from ..animate import bake_to_files
from ..bridge import bake_files, final_mesh, modifier_kinds, press_modifier, scene_objects
from ..reporting import megabytes
from . import clips, formats, sidecar
from .clips import Clip, ExportPlan
from .formats import FORMATS, Size

SIMULATED = 0.5  # share of the progress bar for a simulation
FILE = 5e4  # [bytes] of a file with an empty mesh, at most
SHAPE, KEY = 2000, 12  # [bytes] of a shape key without vertices, and of a key of its animation, at most
STILL = 48  # [bytes] per corner of a face: vertex at rest, normal, two UV maps, triangles


def finals(plan: ExportPlan) -> list[Path]:
    """Return the paths of all files and folders that an export makes."""
    stems = [bake_files.file_name(obj.name) for obj in plan.objects]
    endings = [*(FORMATS[each].ending for each in plan.formats), ".csv", ".json"]
    return [plan.folder / f"{stem}{ending}" for stem in stems for ending in endings]


def estimate(plan: ExportPlan, sizes: Sequence[Size]) -> float:
    """Return the largest size [bytes] of the files of an export; what does not move reduces it."""
    frames, total = plan.last - plan.first + 1, 0.0
    for kind, size in itertools.product((FORMATS[each] for each in plan.formats), sizes):
        total += FILE + frames * kind.bytes_of(size) + kind.pictures * size.pictures
        if kind.exporter:
            total += STILL * size.corners + kind.keyed * frames * (SHAPE + KEY * frames)
    return total


def played(obj: bpy.types.Object, plan: ExportPlan) -> Clip | None:
    """Return the bake that an object plays, None if it plays none."""
    for modifier in obj.modifiers:
        on = modifier.show_render if plan.rendered else modifier.show_viewport
        if not (on and modifier_kinds.is_cache(modifier)):
            continue
        for path, _ in press_modifier.files(modifier)[:1]:
            try:
                _, points = open_point_cache(path)
            except OSError as error:
                raise DimpleError(
                    '"{name}" plays {path}, which cannot be read: {error}. Bake again, or remove the bake.',
                    name=obj.name, path=path, error=error.strerror
                ) from error  # fmt: skip
            graph = bpy.context.view_layer.depsgraph  # not updated: a panel being drawn must not evaluate it
            count = len(obj.evaluated_get(graph).data.vertices) if graph and obj.visible_get() else points.shape[1]
            if points.shape[1] != count:
                raise DimpleError(
                    '"{name}" has {count} vertices, but its bake has {baked}. Bake again, or remove the bake.',
                    name=obj.name, count=count, baked=points.shape[1]
                )  # fmt: skip
            table = path.with_suffix(".csv")
            return Clip(obj=obj, plan=plan, table=table if table.is_file() else None)
    return None


def size_of(context: bpy.types.Context, obj: bpy.types.Object, plan: ExportPlan) -> Size:
    """Return the counts of an object that determine the size of its files."""
    graph = context.view_layer.depsgraph
    mesh = obj.evaluated_get(graph).data if graph else obj.data
    size, cuts = _size(obj, mesh), 0 if played(obj, plan) else final_mesh.cuts_of(context, obj, mesh)
    divided = [each for each in obj.modifiers if hasattr(each, "render_levels") and plan.rendered]
    finer = 4 ** (cuts + sum(each.render_levels - each.levels for each in divided))
    more = finer  # factor on the vertices: half as much again where triangles become three quads
    if finer > 1:
        more *= max(1.0, size.corners / 4 / max(size.vertices, 1))
    return Size(int(more * size.vertices), finer * size.corners, int(more * size.split), size.smooth, size.pictures)


def _size(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> Size:
    """Return the counts of a final mesh of an object; exporters split a vertex where normals or UV maps are."""
    vertices, corners = len(mesh.vertices), len(mesh.loops)
    layers = [final_mesh.get_points(mesh.corner_normals, corners, "vector")]
    for each in mesh.uv_layers:
        layers.append(np.zeros((corners, 3), np.float32))
        each.uv.foreach_get("vector", flat := np.empty(2 * corners, np.float32))
        layers[-1][:, :2] = flat.reshape(-1, 2)
    apart = len(split(final_mesh.corners_of(mesh), np.array(layers))[0])
    return Size(vertices, corners, apart, mesh.normals_domain == "POINT", _pictures(obj))


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
        if [*plan.formats] != ["PC2"]:  # which has no transform
            clips.check_shear(obj, np.array(obj.matrix_world)[None])
    there = [path.name for path in finals(plan) if os.path.lexists(path)]
    if there and not plan.overwrite:
        which = "{path} already exists." if len(there) == 1 else "{path} and {count} other files already exist."
        said = Message(which, path=there[0], count=len(there) - 1)
        raise DimpleError(in_a_row([said, "Choose another folder, or switch Overwrite on."]))


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


def check_space(size: float, folder: Path) -> None:
    """Check that the disk has space for a number of bytes: where it has not, Blender's Alembic exporter ends Blender.

    Raises:
        DimpleError: it has too little.
    """
    enough = size <= shutil.disk_usage(folder).free
    try:
        if enough and hasattr(os, "posix_fallocate"):
            with tempfile.TemporaryFile(dir=folder) as file:  # a quota or a limit may leave less
                os.posix_fallocate(file.fileno(), 0, int(size))
    except OSError:
        enough = False
    if not enough:
        raise DimpleError(
            "The export may need {needed} MB, more than {folder} has free. Choose another folder, fewer frames or "
            "fewer formats.",
            needed=megabytes(size), folder=folder
        )  # fmt: skip


def export(context: bpy.types.Context, plan: ExportPlan, messages: list[str], written: list[Path]) -> Iterator[float]:
    """Export; yield the share that is done. Closing the generator cancels; finished files are kept.

    Args:
        messages: receives sentences for the artist.
        written: receives the path of each file once it is complete.

    Raises:
        DimpleError: an object cannot be exported, files exist already, or the disk refuses.
    """
    with contextlib.ExitStack() as files, bake_files.plain_os_errors("The export", "folder"):
        context.view_layer.update()
        check(plan)
        folder = files.enter_context(bake_files.unfinished_folder(plan.folder))
        check_space(estimate(plan, [size_of(context, obj, plan) for obj in plan.objects]), plan.folder)
        (folder / "simulated").mkdir()
        found = {obj: played(obj, plan) for obj in plan.objects}
        missing = [obj for obj, clip in found.items() if clip is None]
        done = SIMULATED if missing else 0.0
        each_file = (0.99 - done) / (len(plan.objects) * len(plan.formats))  # the rest is for the end
        if missing:
            found |= yield from _simulated(context, plan, missing, folder, messages)
        for obj, clip in found.items():
            described = sidecar.describe(context, clip)
            stem = bake_files.file_name(obj.name)
            if clip.table:
                sidecar.copy_table(clip.table, folder / "table", plan.first, plan.last)
                _commit(folder / "table", plan.folder / f"{stem}.csv", written)
            with _readable_errors(folder), clips.seen(context, clip, folder) as seen:
                for each in plan.formats:
                    yield done
                    final = plan.folder / f"{stem}{FORMATS[each].ending}"
                    part = folder / final.name
                    with _readable_errors(final, each):
                        check_space(estimate(replace(plan, formats=[each]), [_size(obj, seen.mesh)]), plan.folder)
                        FORMATS[each].write(context, seen, part)
                    _commit(part, final, written)
                    described["files"][final.name] = sidecar.describe_file(each, seen)
                    words = json.dumps(described, indent=1, ensure_ascii=False)
                    (folder / "sidecar").write_text(words + "\n", encoding="utf-8")
                    _commit(folder / "sidecar", plan.folder / f"{stem}.json", written)
                    done += each_file


def _simulated(
    context: bpy.types.Context, plan: ExportPlan, missing: list[bpy.types.Object], folder: Path, messages: list[str]
) -> Generator[float, None, dict[bpy.types.Object, Clip]]:
    """Simulate objects that play nothing, and return the clips that they are to play."""
    bake = bake_to_files.BakePlan(  # a bake needs two frames
        objects=missing, first=plan.first, last=max(plan.last, plan.first + 1), folder=folder / "simulated"
    )
    bodies = yield from as_share(bake_to_files.simulate(context, bake, messages), 0.0, SIMULATED)
    return {
        body.obj: Clip(
            obj=body.obj, plan=plan, plays=(body.path, plan.first, body.link.cuts), table=body.path.with_suffix(".csv")
        )
        for body in bodies
    }


def _commit(part: Path, final: Path, written: list[Path]) -> None:
    """Give a finished file its final name. A folder replaces an existing one as a whole."""
    if final.is_dir() and not final.is_symlink():
        os.replace(final, part.with_name(f"{part.name}.old"))  # deleted with the temporary folder
    os.replace(part, final)
    if final not in written:
        written.append(final)


@contextlib.contextmanager
def _readable_errors(path: Path, each: str = "") -> Iterator[None]:
    """Make errors say what could not be written, and where."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, error.filename or str(path)) from error
    except DimpleError as error:
        if not each:
            raise
        raise DimpleError("{label}: {error}", label=FORMATS[each].label, error=error) from error
