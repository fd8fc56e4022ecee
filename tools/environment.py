"""Make and repair the environments under .venv/, one per Blender version.

Each holds Blender as a module (bpy) and the packages that requirements/ pins. A finished environment is stamped with
a hash of its pins and is made again if the stamp is missing or differs. So an interrupted set-up repairs itself, and a
second run costs nothing.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENTS = ROOT / ".venv"
DEV_PINS = ROOT / "requirements" / "dev.txt"
WHEEL_PINS = ROOT / "requirements" / "wheels.txt"
PEER_PINS = ROOT / "requirements" / "peers.txt"
READER_PINS = ROOT / "requirements" / "readers.txt"

# version of bpy: the Python it needs; newest first
BLENDERS = {"5.2.3": "3.13", "5.0.1": "3.11", "4.5.15": "3.11"}
OLDEST = "4.5.15"
POLL_S = 0.05  # interval at which running commands are polled

# libraries that bpy loads on Linux, and the Debian package of each (without libEGL a GPU engine aborts)
SYSTEM_LIBRARIES = {
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
}

PIP = ("-m", "pip", "--disable-pip-version-check", "--no-input")


class Stop(Exception):
    """End the command with a message for the person who ran it."""


def say(text: str) -> None:
    print(f"dev.py: {text}", file=sys.stderr, flush=True)


def run(
    command: Sequence[str | Path], *, folder: Path = ROOT, limit_s: float | None = None, **variables: str
) -> int:
    """Run a command in a folder, by default the repository, and return its exit code."""
    words = [str(word) for word in command]
    try:
        return subprocess.run(words, cwd=folder, env={**os.environ, **variables}, timeout=limit_s).returncode
    except subprocess.TimeoutExpired:
        raise Stop(f"stopped after its limit of {limit_s:.0f} s: {' '.join(words)}") from None


def run_together(commands: Sequence[Sequence[str | Path]], *, limit_s: float) -> list[int]:
    """Run commands in the repository, one for each processor at a time, and return their exit codes.

    They start in the order given. The first prints live; the output of any other is printed once that command and all
    before it have ended.
    """
    lines, until = [[str(word) for word in command] for command in commands], time.monotonic() + limit_s
    with contextlib.ExitStack() as stack:
        outputs = [stack.enter_context(tempfile.TemporaryFile()) if place else None for place in range(len(lines))]
        started: list[subprocess.Popen[bytes]] = []
        waiting, unseen = deque(zip(lines, outputs, strict=True)), deque(outputs)
        while unseen:
            if waiting and sum(process.poll() is None for process in started) < (os.cpu_count() or 1):
                words, output = waiting.popleft()
                process = subprocess.Popen(words, cwd=ROOT, stdout=output, stderr=output and subprocess.STDOUT)
                stack.callback(process.kill)  # does nothing if it has ended
                started.append(process)
                continue
            first = len(lines) - len(unseen)
            late = time.monotonic() > until
            if late or started[first].poll() is not None:
                show(unseen.popleft())
            if late:
                raise Stop(f"stopped after its limit of {limit_s:.0f} s: {' '.join(lines[first])}")
            time.sleep(POLL_S)
    return [process.returncode for process in started]


def show(output: IO[bytes] | None) -> None:
    """Print the output that a command wrote to a file."""
    if output:
        output.seek(0)
        shutil.copyfileobj(output, sys.stdout.buffer)
        sys.stdout.flush()


def require(command: Sequence[str | Path], failure: str) -> None:
    """Run a step of the set-up, silent unless it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        raise Stop(f"{failure} Repair this and run the same command again:\n{done.stdout.strip()}")


def find_python(series: str) -> str | None:
    """Return an interpreter that can make environments, or None; each candidate is run, as a pyenv shim may refuse."""
    places = [Path(folder) / f"python{series}" for folder in os.get_exec_path()]
    places += sorted(Path.home().glob(f".pyenv/versions/{series}*/bin/python{series}"))
    if series == f"{sys.version_info[0]}.{sys.version_info[1]}":
        places.insert(0, Path(getattr(sys, "_base_executable", sys.executable)))
    without_venv = None
    for place in dict.fromkeys(map(str, places)):
        if os.access(place, os.X_OK):
            probe = "import sys; print('%d.%d' % sys.version_info[:2], flush=True); import ensurepip, venv"
            answer = subprocess.run([place, "-c", probe], capture_output=True, text=True)
            if answer.stdout.strip() == series:
                if answer.returncode == 0:
                    return place
                without_venv = without_venv or place
    if without_venv and may_install():  # Debian keeps venv in a package of its own
        install_packages([f"python{series}-venv"])
        return without_venv
    return None


def provide_system_libraries() -> None:
    missing = []
    for library, package in SYSTEM_LIBRARIES.items() if sys.platform == "linux" else ():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(package)
    if missing:
        install_packages(missing)


def may_install() -> bool:
    return sys.platform == "linux" and os.geteuid() == 0 and shutil.which("apt-get") is not None


def install_packages(packages: list[str]) -> None:
    """Install Debian packages; if this process may not, stop with the command that installs them."""
    names = " ".join(packages)
    if not may_install():
        line = f"sudo apt-get install --no-install-recommends {names}"
        raise Stop(f"system libraries are missing. On Debian or Ubuntu run this, then come back:\n  {line}")
    say(f"installing system packages: {names}")
    os.environ["DEBIAN_FRONTEND"] = "noninteractive"
    require(["apt-get", "update", "-qq"], "The package index could not be read.")
    options = ["-y", "-qq", "--no-install-recommends"]
    require(["apt-get", "install", *options, *packages], f"{names} could not be installed.")


def environment(wanted: str | None = None) -> Path:
    """Return the Python of an environment with the wanted Blender, made first if it is not ready.

    Args:
        wanted: a pinned version or its beginning, such as "4.5"; None: the newest for which this machine has a Python.

    Raises:
        Stop: no such version, no Python for it, or a step failed.
    """
    versions = [version for version in BLENDERS if wanted is None or f"{version}.".startswith(f"{wanted}.")]
    if not versions:
        raise Stop(f"Blender {wanted} is not among the pinned versions: {', '.join(BLENDERS)}.")
    provide_system_libraries()
    with alone():
        for version in versions:
            if is_ready(version):
                return python_of(version)
            if interpreter := find_python(BLENDERS[version]):
                make_environment(version, interpreter)
                return python_of(version)
    needed = " or ".join(sorted({BLENDERS[version] for version in versions}))
    raise Stop(
        f"Blender {' or '.join(versions)} needs Python {needed} with venv (Debian: pythonX.Y-venv); "
        "none that runs was found on PATH or in pyenv."
    )


def python_of(version: str) -> Path:
    return ENVIRONMENTS / f"blender-{version}" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def pins_hash() -> str:
    return hashlib.sha256(DEV_PINS.read_bytes() + WHEEL_PINS.read_bytes()).hexdigest()


def is_ready(version: str) -> bool:
    stamp = ENVIRONMENTS / f"blender-{version}" / "pins.sha256"
    return python_of(version).exists() and stamp.exists() and stamp.read_text() == pins_hash()


def make_environment(version: str, interpreter: str) -> None:
    home, python = ENVIRONMENTS / f"blender-{version}", python_of(version)
    say(f"making the environment for Blender {version} with {interpreter}")
    shutil.rmtree(home, ignore_errors=True)
    require([interpreter, "-m", "venv", home], "The virtual environment could not be made.")
    say(f"installing bpy {version} (400 MB to download, 1 GB on disk) and the tools")
    pins: tuple[list[str | Path], ...] = (["-r", WHEEL_PINS], ["-r", DEV_PINS, f"bpy=={version}"])
    for pinned in pins:  # two calls, since only the wheels are pinned by hashes
        require([python, *PIP, "install", "-q", "--no-deps", *pinned], "The packages could not be installed.")
    require([python, *PIP, "check", "-q"], "requirements/dev.txt is not complete.")
    require([python, "-c", "import bpy"], f"Blender {version} is installed but does not start.")
    (home / "pins.sha256").write_text(pins_hash())


def provide_peers(python: Path) -> Path:
    """Return a folder with the solvers that the benchmark compares with; it is not on the environment's path.

    Raises:
        Stop: the packages could not be installed.
    """
    with alone():
        return provide_packages(python, python.parent.parent / "peers", PEER_PINS, "panda3d, 50 to 120 MB to download")


def provide_readers(python: Path) -> Path:
    """Return a folder with the packages that read exported animations; it is not on the environment's path.

    Raises:
        Stop: the packages could not be installed.
    """
    with alone():
        folder = python.parent.parent / "readers"
        return provide_packages(python, folder, READER_PINS, "usd-core, pygltflib, mini-racer")


def provide_packages(python: str | Path, folder: Path, pins: Path, what: str) -> Path:
    """Return a folder with pinned packages, installed first unless they are there.

    Raises:
        Stop: the packages could not be installed.
    """
    stamp = folder / "pins.txt"
    if not (stamp.exists() and stamp.read_text() == pins.read_text()):
        say(f"installing {what}")
        shutil.rmtree(folder, ignore_errors=True)
        command = [python, *PIP, "install", "-q", "--no-deps", "--target", folder, "-r", pins]
        require(command, f"requirements/{pins.name} could not be installed.")
        stamp.write_text(pins.read_text())
    return folder


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Let only one process at a time change .venv/ or wheels/; the lock ends with its process."""
    ENVIRONMENTS.mkdir(exist_ok=True)
    with (ENVIRONMENTS / "lock").open("w") as lock:
        with contextlib.suppress(ImportError):  # Windows has no fcntl
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
