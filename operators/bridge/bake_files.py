"""The paths of bakes on the disk, and the modifier that plays them."""

from __future__ import annotations

import contextlib
import itertools
import os
import tempfile
import tomllib
import zlib
from collections.abc import Iterator
from pathlib import Path

import bpy

from ...core.base import DimpleError
from ...core.message import Message
from ...core.recording import PointCache, open_point_cache
from ..names import BAKED_PRESS, CACHE
from . import press_modifier, rendered_mesh
from .modifier_kinds import is_cache

LONGEST_NAME = 91  # [bytes] of a name: a file name consists of two, checksums and endings, and 255 are allowed
PACKAGE = (__package__ or "").partition(".operators")[0]


def bake_path(context: bpy.types.Context, obj: bpy.types.Object, folder: Path | None = None) -> Path:
    """Return the path of an object's bake, which replaces its last one; in an unsaved .blend only one that it plays.

    Args:
        folder: the folder to use instead; the file then has the name of the object.

    Raises:
        DimpleError: the folder cannot be created.
    """
    if folder:
        return folder / f"{file_name(obj.name)}.pc2"
    stem = _stem(context, obj)
    if bpy.data.filepath:
        return Path(f"{stem}.pc2")
    playing = {path for modifier in obj.modifiers if is_cache(modifier) for path, _ in press_modifier.files(modifier)}
    numbered = (Path(f"{stem}_{number:03d}.pc2") for number in itertools.count(1))
    return next(each for each in numbered if each in playing or not any(each.parent.glob(f"{each.stem}.*")))


def _stem(context: bpy.types.Context, obj: bpy.types.Object) -> Path:
    """Return folder and prefix of the names: the folder of the scene, else that of the .blend, else a user folder.

    Raises:
        DimpleError: the folder cannot be created.
    """
    chosen = context.scene.dimple.cache_dir
    if chosen.startswith("//") and not bpy.data.filepath:
        raise DimpleError(
            "The cache folder is relative to the .blend file, which is not saved yet. Save the file first."
        )
    if chosen:
        folder = Path(bpy.path.abspath(chosen))
    elif bpy.data.filepath:
        folder = Path(bpy.data.filepath).parent
    else:
        # not the extension's own folder: Blender deletes that with the extension, but scenes still play these files
        folder = Path(bpy.utils.user_resource("DATAFILES", path="dimple"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DimpleError(
            "Cannot make the cache folder {folder}: {error}. Choose another.", folder=folder, error=error.strerror
        ) from error
    stem = Path(bpy.data.filepath).stem or "untitled"
    return folder / f"{_shortened(stem, stem)}_{file_name(obj.name)}_bake"


def file_name(name: str) -> str:
    """Return a name that is valid on every disk: without special characters, and at most 100 bytes long."""
    return _shortened(bpy.path.clean_name(name), name)


def _shortened(clean: str, name: str) -> str:
    short = clean.encode()[:LONGEST_NAME].decode(errors="ignore")
    # a checksum, because two names may become equal when they are cleaned and cut
    return short if short == name else f"{short}_{zlib.crc32(name.encode()):08x}"


def version() -> str:
    """Return the version of the extension."""
    manifest = Path(__file__).parents[2] / "blender_manifest.toml"
    return str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])


@contextlib.contextmanager
def unfinished_folder(parent: Path) -> Iterator[Path]:
    """Make a folder for unfinished files, on the disk of their destination, and delete it in the end.

    If Blender is killed the folder remains, and its point caches can be read up to their last frame.
    """
    parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".dimple-", dir=parent, ignore_cleanup_errors=True) as folder:
        yield Path(folder)


@contextlib.contextmanager
def plain_os_errors(doing: str, folder: str = "cache folder") -> Iterator[None]:
    """Turn an OSError into a sentence for the artist.

    Args:
        doing: what may fail, such as "The bake".
        folder: what the artist should replace, such as "cache folder".

    Raises:
        DimpleError: says what failed, where and why.
    """
    try:
        yield
    except OSError as error:
        where = error.filename or Message("the disk")
        raise DimpleError(
            "{doing} failed at {where}: {error}. Choose another {folder}.",
            doing=Message(doing), where=where, error=error.strerror, folder=Message(folder)
        ) from error  # fmt: skip


def play(
    context: bpy.types.Context, obj: bpy.types.Object, path: Path, start_frame: float, cuts: int
) -> bpy.types.Modifier:
    """Make an object play a PC2 file of offsets, after all its modifiers.

    If a render has other vertices than the viewport, a second file beside the first one serves it.

    Args:
        cuts: number of subdivisions of its final mesh.

    Raises:
        OSError: the file is missing, or the second one cannot be written.
    """
    _, samples = open_point_cache(path)
    shown = rendered_mesh.shown(context, obj, samples.shape[1], cuts)
    for each, carried in shown:
        file = path
        if carried:
            file = path.with_name(f"{path.stem}_render.pc2")
            with PointCache(file, len(carried.corners), start_frame) as cache:
                for sample in samples:
                    cache.append(carried.carry(sample))
        plays = each.carrier.modifiers.new(CACHE, "MESH_CACHE")
        plays.cache_format, plays.filepath, plays.frame_start = "PC2", _stored(os.fspath(file)), start_frame
    return press_modifier.add(obj, CACHE, BAKED_PRESS, [each for each, _ in shown])


def _stored(path: str) -> str:
    """Return a path as the .blend stores it: relative if possible, so that a moved project still plays."""
    if not bpy.data.filepath:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:  # another drive
        return os.fspath(path)
