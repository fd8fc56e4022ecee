"""A folder for what is not finished, beside where it goes.

What a killed Blender leaves behind, point caches that can be read up to their last frame, is deleted when the same
computer works in the same place again. The folder of a Blender that is at work is left alone, and those of other
computers, which a render farm has, are too.
"""

from __future__ import annotations

import contextlib
import platform
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO

PREFIX = ".dimple-"
LOCK = "lock"  # a file that whoever works in the folder holds, and that nobody holds once it is killed


@contextlib.contextmanager
def opened(parent: Path) -> Iterator[Path]:
    """Make a folder in another one, which is made too where it is missing, and delete it in the end.

    Raises:
        OSError: it cannot be made.
    """
    parent.mkdir(parents=True, exist_ok=True)
    clear(parent)
    folder = Path(tempfile.mkdtemp(prefix=_prefix(), dir=parent))
    try:
        with _held(folder):
            yield folder
    finally:
        _remove(folder)


def clear(parent: Path) -> None:
    """Delete the folders that killed Blenders of this computer left in a place."""
    for lock in sorted(parent.glob(f"{_prefix()}*/{LOCK}")):
        if _is_free(lock):
            _remove(lock.parent)


def _remove(folder: Path) -> None:
    """Delete a folder, its lock last: whoever is killed on the way leaves what can be found again."""
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            elif path.name != LOCK:
                path.unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)


def _prefix() -> str:
    return f"{PREFIX}{re.sub(r'[^A-Za-z0-9]+', '-', platform.node())[:40]}-"


def _held(folder: Path) -> IO[bytes]:
    """Return the open lock of a folder; it has its name once it is held, so nobody finds one that is about to be."""
    try:
        import fcntl
    except ImportError:  # Windows deletes no file that is open
        return (folder / LOCK).open("wb")
    file = (folder / "opening").open("wb")
    with contextlib.suppress(OSError):  # a disk without locks: then what a killed Blender leaves stays
        fcntl.flock(file, fcntl.LOCK_EX)
        (folder / "opening").rename(folder / LOCK)
    return file


def _is_free(lock: Path) -> bool:
    """Tell whether nobody holds a lock."""
    try:
        import fcntl
    except ImportError:
        with contextlib.suppress(OSError):
            lock.unlink()
            return True
        return False
    with contextlib.suppress(OSError), lock.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False
