"""An exclusive lock on an open file; it ends with the process that holds it, however that ends."""

from __future__ import annotations

import sys
from typing import IO, Any


def lock(file: IO[Any]) -> None:
    """Lock a file.

    Raises:
        OSError: it is locked already.
    """
    if sys.platform == "win32":
        import msvcrt

        file.seek(1 << 40)  # a byte far beyond the end, so that others can read
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
