"""Processes that end when Blender does, run by Blender's own Python."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Final

from ..errors import DimpleError
from .limits import ANSWER_TIME

START: Final = Path(__file__).with_name("start.py")
SECRET: Final = "DIMPLE_DEVICE_SECRET"  # environment variable of the process: no other account can read it


def start(
    words: Sequence[str], errors: IO[bytes] | None, *, script: Path = START, secret: str = ""
) -> subprocess.Popen[bytes]:
    """Start a process that ends when its standard input closes.

    Args:
        words: arguments of its command line, see servo_process.py.
        errors: file for its standard error, None to discard it.
        script: the script that Python runs; its first argument is the folder of pyserial.
        secret: shared with a device on the network.

    Raises:
        DimpleError: Python or pyserial is missing, or the system refuses.
    """
    serial = importlib.util.find_spec("serial")
    if serial is None or serial.origin is None:
        raise DimpleError("pyserial is not installed, so no serial device can be used. Install the extension's zip.")
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | {SECRET: secret}
    try:
        return subprocess.Popen(
            [python(), "-I", "-S", str(script), str(Path(serial.origin).parents[1]), *words],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=errors or subprocess.DEVNULL, env=clean,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0) | getattr(subprocess, "HIGH_PRIORITY_CLASS", 0),
        )  # fmt: skip
    except OSError as error:
        raise DimpleError("The process for the device cannot be started: {error}.", error=error.strerror) from None


def end(process: subprocess.Popen[bytes]) -> None:
    """Close the standard input of a process and wait for it to end; kill it if it does not."""
    if process.stdin:
        process.stdin.close()
    try:
        process.wait(ANSWER_TIME)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def python() -> str:
    """Return the path of Blender's own Python: in some builds sys.executable is None, or Blender itself.

    Raises:
        DimpleError: none is found.
    """
    name, prefix = "python{}.{}".format(*sys.version_info), Path(sys.prefix)
    places = [Path(sys.executable or ""), *(prefix / "bin" / each for each in (name, "python3", "python.exe"))]
    for path in places:
        if "python" in path.name.lower() and path.is_file():
            return str(path)
    raise DimpleError("Blender's Python was not found, so no device can be run. Install Blender from blender.org.")
