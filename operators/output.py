"""What leaves a session: point caches, the table of forces beside them, and the modifier that plays them."""

from __future__ import annotations

import contextlib
import csv
import itertools
import os
import tomllib
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

import bpy

from ..core.base import DimpleError
from ..core.recording import PointCache
from . import curves
from .bridge_write import is_cache
from .names import CACHE

if TYPE_CHECKING:
    from ..core.session import Frame
    from .bridge import Singles

FINGERS = 3
LONGEST_NAME = 91  # bytes; a name has two, a number and endings, and a disk takes 255
_PACKAGE = (__package__ or "").rpartition(".")[0]


class ForceTable:
    """Write one line a frame: force [N], depth [mm], pressure [Pa], volume [m3], work of the fingertips [J]; steps."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", buffering=1, newline="", encoding="utf-8")  # a line is the system's once written
        self._rows = csv.writer(self._file)
        columns = ["frame", "time_s"]
        for number in range(1, FINGERS + 1):
            columns += [f"force_{number}_n", f"law_force_{number}_n", f"depth_{number}_mm"]
        self._rows.writerow([*columns, "pressure_pa", "volume_m3", "rest_volume_m3", "work_j", "steps"])

    def append(self, number: float, time_s: float, frame: Frame) -> None:
        """Add the line of one frame of the animation."""
        row: list[float] = []
        for i in range(FINGERS):
            down = i < len(frame.finger_forces)
            force = float((frame.finger_forces[i] ** 2).sum() ** 0.5) if down else 0.0
            law, depth = (float(frame.law_forces[i]), float(frame.depths[i])) if down else (0.0, 0.0)
            row += [force, law, depth * 1e3]
        numbers = [
            time_s, *row, frame.pressure, frame.volume, frame.rest_volume, frame.work, frame.total_steps
        ]  # fmt: skip
        self._rows.writerow([f"{number:g}", *(f"{value:.9g}" for value in numbers)])

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class Recorder:
    """Record a live session at the frame rate of the scene, whatever the rhythm of the steps.

    Args:
        path: the PC2 file; the table of forces goes beside it.
        start_frame: the frame of the animation that is now.
        fps: frames per second.
        time: of the session now [s].
        local: (N, 3) the coordinates that show now.
    """

    def __init__(self, path: Path, start_frame: int, fps: float, time: float, local: Singles, frame: Frame) -> None:
        self._path, self._start_frame, self._fps = path, start_frame, fps
        self._began = self._time = time
        self._local = local
        with contextlib.ExitStack() as self._files:
            self._cache = open_file(self._files, path, lambda name: PointCache(name, len(local), start_frame))
            self._table = open_file(self._files, path.with_suffix(".csv"), ForceTable)
            self.append(time, local, frame)
            self._files = self._files.pop_all()

    @property
    def take(self) -> tuple[str, int]:
        """Return the path of the PC2 file and its first frame."""
        return str(self._path), self._start_frame

    def append(self, time: float, local: Singles, frame: Frame) -> None:
        """Take in the state at a time [s]; what falls on frames in between is interpolated.

        Raises:
            OSError: the disk refuses; what was written before is kept.
        """
        if time < self._time:  # the session was put back to rest: its clock began anew
            self._began -= self._time - time
            self._time = time
        span = time - self._time
        while (due := self._began + self._cache.samples / self._fps) <= time + 1e-9:
            self._table.append(self._start_frame + self._cache.samples, due - self._began, frame)
            self._cache.append(local if time - due < 1e-9 else self._between(local, (due - self._time) / span))
        self._time, self._local = time, local

    def _between(self, local: Singles, share: float) -> Singles:
        return self._local + (local - self._local) * max(share, 0.0)

    @property
    def frames(self) -> int:
        """Return how many frames there are so far."""
        return self._cache.samples

    def summary(self, name: str, scene_end: int) -> str:
        """Return the sentence for the artist on a recording of an object that has ended."""
        last = self._start_frame + self.frames - 1
        beyond = f", beyond the scene's last frame {scene_end}" if last > scene_end else ""
        return (
            f'Recorded {self.frames} frames of "{name}" to {self._path.name}: when its session has ended, it plays '
            f"them from frame {self._start_frame} to {last}{beyond}."
        )

    def close(self) -> None:
        """Close the files.

        Raises:
            OSError: the disk refuses; the files are closed all the same.
        """
        try:
            self._cache.close()
        finally:
            self._table.close()

    def discard(self) -> None:
        """Close the files and delete them."""
        self._files.close()

    def cut_short(self, name: str, error: OSError) -> str:
        """Return the sentence for the artist when the disk refuses the recording of an object."""
        return (
            f'The recording of "{name}" has ended early: {error.strerror} ({self._path}). '
            "What was recorded until then is kept."
        )


Opened = TypeVar("Opened", bound="Closes")


class Closes(Protocol):
    """What can be closed."""

    def close(self) -> None:
        """Close it."""


def open_file(files: contextlib.ExitStack, path: Path, make: Callable[[Path], Opened]) -> Opened:
    """Open a file that is closed and deleted when `files` are, unless it has another name by then.

    Raises:
        OSError: it cannot be made.
    """
    files.callback(_quietly, path.unlink)
    opened = make(path)
    files.callback(_quietly, opened.close)
    return opened


def _quietly(action: Callable[[], None]) -> None:
    with contextlib.suppress(OSError):
        action()


def take_path(context: bpy.types.Context, obj: bpy.types.Object) -> Path:
    """Return where the next recording of an object goes: a PC2 file of a number that is still free.

    Raises:
        DimpleError: the folder cannot be made.
    """
    return next(path for path in _numbered(context, obj, "take") if not _exists(path))


def bake_path(context: bpy.types.Context, obj: bpy.types.Object, folder: Path | None = None) -> Path:
    """Return where the bake of an object goes: over its last one; in a file without a name only if it plays that.

    Args:
        folder: where it goes anyway, under the name of the object.

    Raises:
        DimpleError: the folder cannot be made.
    """
    if folder:
        return folder / f"{file_name(obj.name)}.pc2"
    if bpy.data.filepath:
        return Path(f"{_stem(context, obj, 'bake')}.pc2")
    playing = {Path(bpy.path.abspath(modifier.filepath)) for modifier in obj.modifiers if is_cache(modifier)}
    return next(path for path in _numbered(context, obj, "bake") if path in playing or not _exists(path))


def _numbered(context: bpy.types.Context, obj: bpy.types.Object, kind: str) -> Iterator[Path]:
    stem = _stem(context, obj, kind)
    return (Path(f"{stem}_{number:03d}.pc2") for number in itertools.count(1))


def _exists(path: Path) -> bool:
    return path.exists() or path.with_suffix(".csv").exists()


def _stem(context: bpy.types.Context, obj: bpy.types.Object, kind: str) -> Path:
    """Return folder and beginning of the names: in the scene's folder, else beside the .blend, else the preferred one.

    Raises:
        DimpleError: the folder cannot be made.
    """
    chosen = context.scene.dimple.cache_dir
    if chosen.startswith("//") and not bpy.data.filepath:
        raise DimpleError("The cache folder is beside the .blend, which has no place yet. Save the file first.")
    if chosen:
        folder = Path(bpy.path.abspath(chosen))
    elif bpy.data.filepath:
        folder = Path(bpy.data.filepath).parent
    else:
        folder = _preferred_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DimpleError(f"Cannot make the cache folder {folder}: {error.strerror}. Choose another.") from error
    stem = Path(bpy.data.filepath).stem or "untitled"
    return folder / f"{_shortened(stem, stem)}_{file_name(obj.name)}_{kind}"


def file_name(name: str) -> str:
    """Return a name that every disk takes: without what a path means something by, at most 100 bytes long."""
    return _shortened(bpy.path.clean_name(name), name)


def _shortened(clean: str, name: str) -> str:
    short = clean.encode()[:LONGEST_NAME].decode(errors="ignore")
    # two names may come out alike once cleaned and cut
    return short if short == name else f"{short}_{zlib.crc32(name.encode()):08x}"


def version() -> str:
    """Return the version of the extension."""
    manifest = Path(__file__).parent.parent / "blender_manifest.toml"
    return str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])


def _preferred_folder() -> Path:
    """Return where recordings go that have no other place; it may be missing."""
    settings = bpy.context.preferences.addons.get(_PACKAGE)
    chosen = settings.preferences.cache_dir if settings else ""
    # not the extension's own folder: Blender deletes that with the extension, and scenes go on playing these files
    return Path(bpy.path.abspath(chosen) if chosen else bpy.utils.user_resource("DATAFILES", path="dimple"))


@contextlib.contextmanager
def plain_os_errors(doing: str, folder: str = "cache folder") -> Iterator[None]:
    """Turn what the disk refuses into a sentence for the artist.

    Args:
        folder: what it was to be written to.

    Raises:
        DimpleError: with what was being done, where, and why it failed.
    """
    try:
        yield
    except OSError as error:
        where = error.filename or "the disk"
        raise DimpleError(f"{doing} failed at {where}: {error.strerror}. Choose another {folder}.") from error


def attach_cache(obj: bpy.types.Object, path: str, start_frame: int) -> bpy.types.Modifier:
    """Let an object play a PC2 file, first of its modifiers; an earlier bake makes room.

    Where the scene asks for curves it has those of the table beside the file too.
    """
    detach_cache(obj)
    add_curves(obj, Path(path))
    modifier = obj.modifiers.new(CACHE, "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = _stored(path)
    modifier.frame_start = start_frame
    obj.modifiers.move(len(obj.modifiers) - 1, 0)
    return modifier


def add_curves(obj: bpy.types.Object, cache: Path) -> None:
    """Give an object the curves of the table beside a PC2 file, where the scene asks for curves."""
    if bpy.context.scene.dimple.use_curves:
        with contextlib.suppress(OSError):  # a recording of which the disk has taken no table still plays
            curves.add(obj, cache.with_suffix(".csv"))


def detach_cache(obj: bpy.types.Object) -> int:
    """Take our Mesh Cache modifiers and curves off an object; return how many modifiers there were."""
    curves.remove(obj)
    caches = [modifier for modifier in obj.modifiers if is_cache(modifier)]
    for modifier in caches:
        obj.modifiers.remove(modifier)
    return len(caches)


def _stored(path: str) -> str:
    """Return a path as it goes into the file: relative where it can, so that a moved project still plays."""
    if not bpy.data.filepath:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:  # another drive
        return os.fspath(path)
