"""Processes that end with ours, run by Blender's own Python."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import IO, Final

from ..errors import DimpleError
from .limits import ANSWER_TIME

START: Final = Path(__file__).with_name("start.py")
PROBE: Final = "import sys, mmap, select, tomllib; print('python', *sys.version_info[:2])"


def start(words: Sequence[str], errors: IO[bytes] | None, *, script: Path = START) -> subprocess.Popen[bytes]:
    """Start a process that ends when its standard input closes.

    Args:
        words: of its command line, see servo_process.py.
        errors: file for what it writes to standard error, None for none.
        script: what Python runs; its first argument is the folder of pyserial.

    Raises:
        DimpleError: there is no Python or no pyserial to start it with, or the system refuses.
    """
    serial = importlib.util.find_spec("serial")
    if serial is None or serial.origin is None:
        raise DimpleError("pyserial is not installed, so no serial device can be used. Install the extension's zip.")
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    try:
        return subprocess.Popen(
            [python(), "-I", "-S", str(script), str(Path(serial.origin).parents[1]), *words],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=errors or subprocess.DEVNULL, env=clean,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0) | getattr(subprocess, "HIGH_PRIORITY_CLASS", 0),
        )  # fmt: skip
    except OSError as error:
        raise DimpleError("The process for the device cannot be started: {error}.", error=error.strerror) from None


def end(process: subprocess.Popen[bytes]) -> None:
    """Close the standard input of a process and wait for it to end; kill one that does not."""
    if process.stdin:
        process.stdin.close()
    try:
        process.wait(ANSWER_TIME)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@lru_cache(maxsize=1)
def python() -> str:
    """Return a Python to start processes with: Blender's own.

    Raises:
        DimpleError: none is found.
    """
    for path in _candidates():
        try:
            done = subprocess.run([path, "-I", "-S", "-c", PROBE], capture_output=True, timeout=10, check=False)
        except (OSError, subprocess.TimeoutExpired):
            continue
        if done.stdout.startswith(b"python 3"):
            return path
    raise DimpleError("Blender's Python was not found, so no device can be run. Install Blender from blender.org.")


def _candidates() -> Iterator[str]:
    """Yield where a Python may be: in some builds of Blender sys.executable is None, or Blender itself."""
    name = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    for path in (sys.executable, getattr(sys, "_base_executable", None)):
        if path and "python" in Path(path).name.lower():
            yield path
    for prefix in dict.fromkeys((sys.prefix, sys.exec_prefix, sys.base_prefix)):
        for place in (f"bin/{name}", "bin/python3", "bin/python.exe", "python.exe"):
            if (Path(prefix) / place).is_file():
                yield str(Path(prefix) / place)
