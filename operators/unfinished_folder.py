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
OPENING = "opening"  # the lock before it is held
LOCK = "lock"  # a file that whoever works in the folder holds, and that nobody holds once it is killed


@contextlib.contextmanager
def opened(parent: Path) -> Iterator[Path]:
    """Make a folder in another one, which is made too where it is missing, and delete it in the end.

    Raises:
        OSError: it cannot be made.
    """
    parent.mkdir(parents=True, exist_ok=True)
    clear(parent)
    folder, lock = _made(parent)
    try:
        with lock:
            yield folder
    finally:
        _remove(folder)


def clear(parent: Path) -> None:
    """Delete the folders that killed Blenders of this computer left in a place."""
    for folder in sorted(parent.glob(f"{_prefix()}*/")):
        with contextlib.suppress(OSError):
            folder.rmdir()  # nothing is in it: whoever has just made it makes another
        for lock in (folder / LOCK, folder / OPENING):
            if lock.exists():
                _remove_if_free(lock)


def _made(parent: Path) -> tuple[Path, IO[bytes]]:
    """Make a folder and its open lock; where another Blender clears it before it is held, make another."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix=_prefix(), dir=parent))
        try:
            return folder, _held(folder)
        except FileNotFoundError:
            continue
        except OSError:
            _remove(folder)
            raise


def _remove(folder: Path) -> None:
    """Delete a folder, its lock last: whoever is killed on the way leaves what can be found again."""
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            elif path.name not in (LOCK, OPENING):
                path.unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)


def _prefix() -> str:
    return f"{PREFIX}{re.sub(r'[^A-Za-z0-9]+', '-', platform.node())[:40]}-"


def _held(folder: Path) -> IO[bytes]:
    """Return the open lock of a folder; it has its name once it is held.

    Raises:
        OSError: it cannot be made; FileNotFoundError where the folder is gone.
    """
    try:
        import fcntl
    except ImportError:  # Windows deletes no file that is open
        return (folder / LOCK).open("wb")
    file = (folder / OPENING).open("wb")
    try:
        fcntl.flock(file, fcntl.LOCK_EX)
    except OSError:  # a disk without locks: then what a killed Blender leaves stays
        return file
    try:
        (folder / OPENING).rename(folder / LOCK)
    except OSError:
        file.close()
        raise
    return file


def _remove_if_free(lock: Path) -> None:
    """Delete the folder of a lock that nobody holds; it is held meanwhile, so whoever is about to hold it waits."""
    with contextlib.suppress(OSError):
        try:
            import fcntl
        except ImportError:
            lock.unlink()
            _remove(lock.parent)
            return
        with lock.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _remove(lock.parent)
