"""Compile the native core for this machine and for every platform of the extension, with the pinned ziglang."""

from __future__ import annotations

import base64
import bz2
import hashlib
import io
import os
import platform
import re
import shutil
import sys
import tarfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from .environment import ENVIRONMENTS, ROOT, Stop, provide_packages, require, say

SOURCES = ROOT / "core" / "native"
BUILD = ROOT / "build" / "native"
WHEELS = ROOT / "wheels"
NUMBERS = SOURCES / "constants.h"
ARCHIVE = SOURCES / "sources.tar.bz2"  # the license asks that sources accompany machine code
PINS = ROOT / "requirements" / "native.txt"
ZIG = ENVIRONMENTS / "zig"
PACKAGE = "dimple_native"

FLAGS = (
    "-std=c11", "-O3", "-fno-unroll-loops", "-fno-vectorize", "-fomit-frame-pointer", "-fPIC", "-fvisibility=hidden",
    "-fno-math-errno", "-fno-trapping-math", "-Wall", "-Wextra", "-Werror",
)  # fmt: skip
# fused multiply-add saves a tenth of the time; without it double precision gives the same bits on every machine
FUSE = {32: "-ffp-contract=on", 64: "-ffp-contract=off"}
ONCE = "api", "threads", "cells", "flips", "seeds", "carriers", "falling"  # compiled once for all instruction sets
VARIANTS = {"base": (), "avx2": ("-mavx2", "-mfma")}
SMALL = "-Os"  # for the fallback set, which only processors from before 2013 use, and zig's runtime: 50 kB less
DOUBLE = "-DDM_DOUBLE"  # compiles bodies in double precision too; only tests use them


@dataclass(frozen=True, slots=True)
class Platform:
    """A platform: its names for zig, ctypes and Python's wheels, and the instruction sets to compile for."""

    triple: str
    library: str
    tag: str
    sets: tuple[str, ...]


PLATFORMS = {
    "linux-x64": Platform("x86_64-linux-gnu.2.17", "libdimple_core.so", "manylinux_2_17_x86_64", ("base", "avx2")),
    "windows-x64": Platform("x86_64-windows-gnu", "dimple_core.dll", "win_amd64", ("base", "avx2")),
    "windows-arm64": Platform("aarch64-windows-gnu", "dimple_core.dll", "win_arm64", ("base",)),
    "macos-arm64": Platform("aarch64-macos.11.0", "libdimple_core.dylib", "macosx_11_0_arm64", ("base",)),
    "macos-x64": Platform("x86_64-macos.11.0", "libdimple_core.dylib", "macosx_11_0_x86_64", ("base", "avx2")),
}


def provide_library(python: str | Path) -> None:
    """Put an up-to-date library for this machine beside its sources.

    Raises:
        Stop: it cannot be compiled.
    """
    (ROOT / "core" / "constants.py").write_text(shared_constants())
    name = this_platform()
    place, built = SOURCES / PLATFORMS[name].library, compile_library(python, name, DOUBLE)
    if not place.exists() or place.read_bytes() != built.read_bytes():
        fresh = place.with_suffix(".new")  # a process that has the old library loaded keeps the old file
        shutil.copyfile(built, fresh)
        os.replace(fresh, place)


def shared_constants() -> str:
    """Return core/constants.py: the numbers of the first section of constants.h."""
    section = NUMBERS.read_text().partition("/* Numbers that Python needs too")[2].partition("\n\n")[0]
    found = re.findall(r"^#define DM_(\w+) +(\S+)", section, re.MULTILINE)
    words = '"""What C and Python both must know, written by `dev.py native` from native/constants.h."""\n\n'
    return words + "".join(f"{name} = {value.removeprefix('DM_')}\n" for name, value in found)


def provide_wheels(python: str | Path) -> list[Path]:
    """Make the wheel of each platform and the archive of the sources.

    Raises:
        Stop: a library cannot be compiled.
    """
    wheels = []
    for name, target in PLATFORMS.items():
        wheel = WHEELS / f"{PACKAGE}-{version()}-py3-none-{target.tag}.whl"
        content = wheel_content(target.tag, target.library, compile_library(python, name).read_bytes())
        if not wheel.exists() or wheel.read_bytes() != content:
            WHEELS.mkdir(exist_ok=True)
            wheel.write_bytes(content)
        wheels.append(wheel)
    for old in set(WHEELS.glob(f"{PACKAGE}-*.whl")) - set(wheels):
        old.unlink()
    content = packed_sources()
    if not ARCHIVE.exists() or ARCHIVE.read_bytes() != content:
        ARCHIVE.write_bytes(content)
    return wheels


def packed_sources() -> bytes:
    """Return an archive of the C sources and of this file, which compiles them; its bytes are reproducible."""
    memory = io.BytesIO()
    with tarfile.open(fileobj=memory, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for path in (Path(__file__), *sorted(SOURCES.glob("*.[ch]"))):
            entry = tarfile.TarInfo(path.name)
            entry.size = path.stat().st_size
            with path.open("rb") as content:
                archive.addfile(entry, content)
    return bz2.compress(memory.getvalue())


def this_platform() -> str:
    """Return the name of this machine's platform.

    Raises:
        Stop: there is no native core for it.
    """
    machine = platform.machine().lower()
    system = {"linux": "linux", "win32": "windows", "darwin": "macos"}.get(sys.platform, "")
    kind = {"x86_64": "x64", "amd64": "x64", "arm64": "arm64", "aarch64": "arm64"}.get(machine, "")
    name = f"{system}-{kind}"
    if name not in PLATFORMS:
        raise Stop(f"there is no native core for {sys.platform} {machine}")
    return name


def version() -> str:
    """Return the version of the wheels; it includes that of the C interface, or Blender would keep an old library."""
    found = re.search('^version = "(.+)"', (ROOT / "blender_manifest.toml").read_text(), re.MULTILINE)
    abi = re.search(r"^#define DM_ABI (\d+)", NUMBERS.read_text(), re.MULTILINE)
    assert found and abi
    return f"{found[1]}.post{abi[1]}"


def compile_library(python: str | Path, name: str, *more: str) -> Path:
    """Return the library of a platform, compiled if a source or a pin has changed.

    Args:
        python: the Python of an environment, which installs the compiler.
        name: the platform.
        more: further options for the compiler; each choice of options has a folder of its own.

    Raises:
        Stop: there is no compiler, or it refused.
    """
    target, folder = PLATFORMS[name], BUILD / "".join([name, *more])
    library, stamp = folder / target.library, folder / "sources.sha256"
    if library.exists() and stamp.exists() and stamp.read_text() == sources_hash():
        return library
    zig = compiler(python)
    say(f"compiling the native core for {name}")
    folder.mkdir(parents=True, exist_ok=True)
    words: list[list[str | Path]] = [[FUSE[64], SOURCES / f"{each}.c", "-o", folder / f"{each}.o"] for each in ONCE]
    for kind in target.sets:
        for bits in (32, 64) if DOUBLE in more else (32,):
            options: list[str | Path] = [f"-DDM_BITS={bits}", f"-DDM_SET={kind}", *VARIANTS[kind], FUSE[bits]]
            options += [SMALL] if kind != target.sets[-1] else []
            words.append([*options, SOURCES / "variant.c", "-o", folder / f"{kind}{bits}.o"])
    command: list[str | Path] = [zig, "cc", "-target", target.triple, *more]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda rest: quiet([*command, *FLAGS, "-c", *rest]), words))
    objects = [rest[-1] for rest in words]
    system = ["-lm", "-lpthread"] if name.startswith("linux") else []
    quiet([*command, SMALL, "-shared", "-s", "-o", library, *objects, *system])
    stamp.write_text(sources_hash())
    return library


def compiler(python: str | Path) -> Path:
    """Return the path of zig, after installing the pinned version if it is missing.

    Raises:
        Stop: it could not be installed.
    """
    zig = ZIG / "ziglang" / ("zig.exe" if os.name == "nt" else "zig")
    if not zig.exists():
        shutil.rmtree(ZIG, ignore_errors=True)
    provide_packages(python, ZIG, PINS, "the C compiler (ziglang, 100 MB to download)")
    return zig


def sources_hash() -> str:
    files = [PINS, *sorted(SOURCES.glob("*.[ch]")), Path(__file__)]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def quiet(command: list[str | Path]) -> None:
    require(command, "The compiler refused.")


def wheel_content(tag: str, name: str, library: bytes) -> bytes:
    """Return a wheel with one package that holds the library; its bytes are reproducible."""
    info = f"{PACKAGE}-{version()}.dist-info"
    kind = f"Wheel-Version: 1.0\nGenerator: dimple\nRoot-Is-Purelib: false\nTag: py3-none-{tag}\n"
    metadata = f"Metadata-Version: 2.1\nName: {PACKAGE}\nVersion: {version()}\nLicense: GPL-3.0-or-later\n"
    files = {
        f"{PACKAGE}/__init__.py": b'"""The compiled core of Dimple."""\n',
        f"{PACKAGE}/{name}": library,
        f"{info}/METADATA": metadata.encode(),
        f"{info}/WHEEL": kind.encode(),
    }
    record = "".join(f"{name},sha256={_digest(content)},{len(content)}\n" for name, content in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED, 9)
    return memory.getvalue()


def _digest(content: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
