#!/usr/bin/env python3
"""Run everything a developer of Dimple runs, from a fresh clone: `python3 dev.py COMMAND`.

Needs Python 3.11 or 3.13 and the package registries, nothing else. Every command first makes what it
lacks: an environment with Blender as a module under .venv/, one per Blender version, filled with the
versions pinned in requirements/, and the wheels the extension ships. A finished environment is
stamped with a hash of its pins; one without that stamp is made anew, so an interrupted set-up mends
itself and a second run costs nothing.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent
BUILD = ROOT / "build"
ENVIRONMENTS = ROOT / ".venv"
WHEELS = ROOT / "wheels"
DEV_PINS = ROOT / "requirements" / "dev.txt"
WHEEL_PINS = ROOT / "requirements" / "wheels.txt"

# version of bpy: the Python it needs; newest first
BLENDERS = {"5.2.3": "3.13", "5.0.1": "3.11", "4.5.15": "3.11"}
OLDEST = "4.5.15"

# what bpy loads on Linux, and the Debian package that brings it (libEGL: without it a GPU engine aborts)
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

TOOL = "bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py"

BLENDER_TESTS_LIMIT_S = 900  # Blender 4.5 hangs at exit when a timer is left registered
SCRIPT_LIMIT_S = 1800
NO_TESTS_COLLECTED = 5  # pytest's exit code


class Stop(Exception):
    """End the command with a message for the person who ran it."""


def say(text: str) -> None:
    print(f"dev.py: {text}", file=sys.stderr, flush=True)


def run(command: Sequence[str | Path], *, limit_s: float | None = None, **environment: str) -> int:
    """Run a command in the repository and return its exit code."""
    words = [str(word) for word in command]
    try:
        return subprocess.run(words, cwd=ROOT, env={**os.environ, **environment}, timeout=limit_s).returncode
    except subprocess.TimeoutExpired:
        raise Stop(f"Stopped after {limit_s:.0f} s without an end: {' '.join(words)}") from None


def require(command: Sequence[str | Path], failure: str) -> None:
    if run(command) != 0:
        raise Stop(f"{failure} The reason is in the lines above; the same command run again starts this step anew.")


# the machine


def interpreters(series: str) -> Iterator[str]:
    """Yield the paths where this machine may keep Python `series`, the running one first."""
    if sys.version_info[:2] == tuple(map(int, series.split("."))):
        yield getattr(sys, "_base_executable", sys.executable)
    for folder in os.get_exec_path():
        yield str(Path(folder) / f"python{series}")
    for home in sorted(Path.home().glob(f".pyenv/versions/{series}*"), reverse=True):
        yield str(home / "bin" / f"python{series}")


def find_python(series: str) -> str | None:
    """Return an interpreter that runs (a pyenv shim may refuse) and can make environments."""
    without_venv = None
    for path in dict.fromkeys(interpreters(series)):
        if not os.access(path, os.X_OK):
            continue
        probe = "import sys; print('%d.%d' % sys.version_info[:2]); import ensurepip, venv"
        answer = subprocess.run([path, "-c", probe], capture_output=True, text=True)
        if answer.returncode == 0 and answer.stdout.strip() == series:
            return path
        if answer.stdout.strip() == series:
            without_venv = path
    if without_venv:  # Debian keeps venv in a package of its own
        install_packages([f"python{series}-venv"])
    return without_venv


def install_packages(packages: list[str]) -> None:
    """Install Debian packages, or say how to."""
    line = f"apt-get install -y --no-install-recommends {' '.join(packages)}"
    if not shutil.which("apt-get"):
        raise Stop(f"Missing system packages. Install what your system calls: {' '.join(packages)}")
    if os.geteuid() != 0:
        raise Stop(f"Missing system packages. Run this, then the same command again:\n  sudo {line}")
    say(f"installing system packages: {' '.join(packages)}")
    require(["apt-get", "update", "-qq"], "Could not read the package index.")
    quiet = ["env", "DEBIAN_FRONTEND=noninteractive", *line.replace("-y", "-y -qq").split()]
    require(quiet, f"Could not install {' '.join(packages)}.")


def provide_system_libraries() -> None:
    if not sys.platform.startswith("linux"):
        return
    missing = []
    for library, package in SYSTEM_LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(package)
    if missing:
        install_packages(missing)


# the environment


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Let one dev.py at a time change .venv/ and wheels/; a killed one leaves no lock behind."""
    ENVIRONMENTS.mkdir(exist_ok=True)
    with (ENVIRONMENTS / "lock").open("w") as lock:
        with contextlib.suppress(ImportError):  # Windows has no fcntl
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def shipped_wheels(python: str | Path) -> list[Path]:
    """Return the wheels the extension ships, downloaded when they are not the pinned ones."""
    pinned = set(re.findall(r"--hash=sha256:(\w+)", WHEEL_PINS.read_text()))
    if {hashlib.sha256(wheel.read_bytes()).hexdigest() for wheel in WHEELS.glob("*.whl")} != pinned:
        shutil.rmtree(WHEELS, ignore_errors=True)
        say("downloading the wheels the extension ships")
        options = ["--require-hashes", "--only-binary", ":all:", "-d", WHEELS, "-r", WHEEL_PINS]
        require([python, *PIP, "download", "-q", "--no-deps", *options], "Could not download the wheels.")
    return sorted(WHEELS.glob("*.whl"))


def environment(wanted: str | None = None) -> Path:
    """Return the Python of an environment with the wanted Blender, made first where it is not ready.

    Args:
        wanted: a pinned version or its beginning, as "4.5"; None is the newest this machine has a Python for.

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
    needed = " or ".join(dict.fromkeys(BLENDERS[version] for version in versions))
    raise Stop(f"Blender {' or '.join(versions)} needs Python {needed}; none that runs was found on PATH or in pyenv.")


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
    require([interpreter, "-m", "venv", home], "Could not make a virtual environment.")
    wheels = shipped_wheels(python)
    say(f"installing bpy {version} (400 MB to download, 1 GB on disk) and the tools")
    pinned = ["-r", DEV_PINS, f"bpy=={version}", *wheels]
    require([python, *PIP, "install", "-q", "--no-deps", *pinned], "Could not install the pinned packages.")
    require([python, *PIP, "check", "-q"], "requirements/dev.txt lacks a package.")
    require([python, "-c", "import bpy"], f"Blender {version} is installed but does not start.")
    (home / "pins.sha256").write_text(pins_hash())


def build_zip(python: str | Path, folder: Path) -> Path:
    """Validate the extension and build its zip with Blender's own tool, in plain Python.

    Args:
        python: the Python of an environment.
        folder: where the zip goes.

    Returns:
        The path of the zip.

    Raises:
        Stop: Blender's tool refused.
    """
    with alone():
        shipped_wheels(python)
    home = Path(python).parent.parent
    tool = next(home.glob("lib*/python*/site-packages/" + TOOL), None) or next(home.glob("Lib/site-packages/" + TOOL))
    name = re.search('^version = "(.+)"', (ROOT / "blender_manifest.toml").read_text(), re.MULTILINE)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"dimple-{name[1]}.zip"
    build = ["build", "--source-dir", ROOT, "--output-filepath", path]
    for words in (["validate", ROOT], build, ["validate", path]):
        answer = subprocess.run([python, tool, *words], capture_output=True, text=True)
        if answer.returncode != 0:
            raise Stop(f"Blender's extension tool refused:\n{answer.stdout}{answer.stderr}")
    return path


# the commands: each takes the parsed options and returns an exit code


def build(options: argparse.Namespace) -> int:
    """validate the extension and build its zip"""
    path = build_zip(environment(options.blender), options.out or BUILD)
    say(f"built {path} ({path.stat().st_size / 1e6:.2f} MB)")
    return 0


def test(options: argparse.Namespace) -> int:
    """run the tests; further arguments go to pytest"""
    python = environment(options.blender)
    paths = [word for word in options.rest if Path(word.partition("::")[0]).parts[:1] == ("tests",)]
    flags = [word for word in options.rest if word not in paths]
    inside = [path for path in paths if Path(path).parts[:2] == ("tests", "blender")]
    outside = [path for path in paths if path not in inside]
    # core and the installed extension are the same modules under two names: one process never holds both
    codes = []
    if outside or not paths:
        codes.append(run([python, "-m", "pytest", *flags, *(outside or ["tests", "--ignore=tests/blender"])]))
    if inside or not paths:
        command = [python, "-m", "pytest", *flags, *(inside or ["tests/blender"])]
        codes.append(run(command, limit_s=BLENDER_TESTS_LIMIT_S))
    if all(code == NO_TESTS_COLLECTED for code in codes):
        return NO_TESTS_COLLECTED
    return next((code for code in codes if code not in (0, NO_TESTS_COLLECTED)), 0)


def lint(options: argparse.Namespace) -> int:
    """check the sources with ruff and mypy"""
    python = environment(options.blender)
    return run([python, "-m", "ruff", "check", "."]) or run([python, "-m", "mypy", "-p", "core"])


def core(options: argparse.Namespace) -> int:
    """run `python -m core` with the arguments that follow"""
    return run([environment(options.blender), "-m", "core", *options.rest])


def demo(options: argparse.Namespace) -> int:
    """press the samples in Blender and write pictures, curves, animation and a summary"""
    return in_blender("blend_samples/demo.py", options.blender, options.out or BUILD / "demo")


def window(options: argparse.Namespace) -> int:
    """drive the extension in a real Blender window"""
    return in_blender("tests/window/run.py", options.blender, options.out or BUILD / "window")


def samples(options: argparse.Namespace) -> int:
    """make the .blend files of blend_samples/ again, in the oldest Blender so that all can open them"""
    return in_blender("blend_samples/make_samples.py", options.blender or OLDEST, None)


def in_blender(script: str, wanted: str | None, out: Path | None) -> int:
    """Run a script that installs the freshly built zip into a throwaway Blender profile."""
    python = environment(wanted)
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        command = [python, script, "--zip", build_zip(python, BUILD)]
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
            command += ["--out", out.resolve()]
        return run(command, limit_s=SCRIPT_LIMIT_S, BLENDER_USER_RESOURCES=profile)


def ci(_options: argparse.Namespace) -> int:
    """run what continuous integration runs"""
    return run(["bash", ".ci/run"])


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="dev.py", description=__doc__.partition("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for command in (demo, test, build, lint, window, samples, core, ci):
        sub = commands.add_parser(command.__name__, help=command.__doc__, allow_abbrev=False)
        sub.set_defaults(action=command, out=None)
        sub.add_argument("--blender", metavar="VERSION", help=f"one of {', '.join(BLENDERS)}, or its beginning")
        if command in (demo, build, window):
            sub.add_argument("--out", type=Path, metavar="DIR", help="where the results go")
    options, options.rest = parser.parse_known_args(words)
    if options.rest and options.action not in (test, core):
        parser.error(f"unknown arguments: {' '.join(options.rest)}")
    try:
        return options.action(options)
    except Stop as stop:
        say(str(stop))
        return 1
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
