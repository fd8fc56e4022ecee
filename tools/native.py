"""Compile the native core for this machine and for every platform of the extension, with the pinned ziglang."""

from __future__ import annotations

import base64
import bz2
import hashlib
import io
import lzma
import os
import platform
import re
import shutil
import struct
import sys
import tarfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from .environment import ENVIRONMENTS, ROOT, Stop, provide_packages, require, say

SOURCES = ROOT / "core" / "native"
BUILD = ROOT / "build" / "native"
WHEELS = ROOT / "wheels"
ARCHIVE = SOURCES / "sources.tar.bz2"  # they go where the machine code goes; packed together they take a third less
SHORT = 1000  # bytes: the properties of LZMA would be most of a file
PINS = ROOT / "requirements" / "native.txt"
ZIG = ENVIRONMENTS / "zig"
PACKAGE = "dimple_native"

FLAGS = (
    "-std=c11", "-O3", "-fno-unroll-loops", "-fno-vectorize", "-fomit-frame-pointer", "-fPIC", "-fvisibility=hidden",
    "-fno-math-errno", "-fno-trapping-math", "-Wall", "-Wextra", "-Werror",
)  # fmt: skip
NO_UNWINDING = "-fno-asynchronous-unwind-tables", "-fno-unwind-tables"  # 3 kB less; Windows' calls want them
# fused multiply-add is a tenth of the time; without it double precision has the same bits on every machine
FUSE = {32: "-ffp-contract=on", 64: "-ffp-contract=off"}
ONCE_SMALL = "api", "cells", "falling", "many", "seeds"  # of them, what is not run over and over
ONCE = "api", "many", "cells", "seeds", "motions", "falling"  # compiled once for all instruction sets
VARIANTS = {"base": (), "avx2": ("-mavx2", "-mfma")}
SMALL = "-Os"  # of the set that only processors from before 2013 take, and of what is linked in: 50 kB less of the zip


@dataclass(frozen=True, slots=True)
class Platform:
    """Name a platform as zig, ctypes and Python's wheels do, and the instruction sets to compile for."""

    triple: str
    library: str
    tag: str
    sets: tuple[str, ...]


DOUBLE = "-DDM_DOUBLE"  # bodies in double precision too, for tests; what ships is smaller

PLATFORMS = {
    "linux-x64": Platform("x86_64-linux-gnu.2.17", "libdimple_core.so", "manylinux_2_17_x86_64", ("base", "avx2")),
    "windows-x64": Platform("x86_64-windows-gnu", "dimple_core.dll", "win_amd64", ("base", "avx2")),
    "macos-arm64": Platform("aarch64-macos.11.0", "libdimple_core.dylib", "macosx_11_0_arm64", ("base",)),
    # one Mac that runs this system is without AVX2, of 2013: numpy stands in there, and the zip is 50 kB smaller
    "macos-x64": Platform("x86_64-macos.11.0", "libdimple_core.dylib", "macosx_11_0_x86_64", ("avx2",)),
}


def provide_library(python: str | Path) -> bool:
    """Put the library of this machine beside its sources, where it is not up to date; tell whether it is there."""
    name = this_platform()
    if name is None:
        say("there is no native core for this kind of machine: numpy stands in")
        return False
    place = SOURCES / PLATFORMS[name].library
    try:
        built = compile_library(python, name, DOUBLE)
    except Stop as stop:
        say(f"the native core was not compiled, numpy stands in: {stop}")
        return False
    if not place.exists() or place.read_bytes() != built.read_bytes():
        fresh = place.with_suffix(".new")  # a library in use must not change under its user
        shutil.copyfile(built, fresh)
        os.replace(fresh, place)
    return True


def provide_wheels(python: str | Path, *, must: bool = False) -> list[Path]:
    """Make the wheels of all platforms; one that cannot be compiled is hollow, and numpy stands in there.

    Raises:
        Stop: one cannot be compiled, and it must.
    """
    wheels = []
    for name, target in PLATFORMS.items():
        wheel = WHEELS / f"{PACKAGE}-{version()}-py3-none-{target.tag}.whl"
        try:
            library = {target.library: compile_library(python, name).read_bytes()}
        except Stop as stop:
            if must:
                raise
            say(f"the wheel for {name} is hollow, numpy stands in there: {stop}")
            library = {}
        content = wheel_content(target.tag, library)
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
    """Return an archive of the C sources and of what compiles them, the same bytes whenever it is made."""
    memory = io.BytesIO()
    with tarfile.open(fileobj=memory, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for path in (Path(__file__), *sorted(SOURCES.glob("*.[ch]"))):
            entry = tarfile.TarInfo(path.name)
            entry.size = path.stat().st_size
            with path.open("rb") as content:
                archive.addfile(entry, content)
    return bz2.compress(memory.getvalue())  # of text, a fifteenth less than xz


def this_platform() -> str | None:
    machine = platform.machine().lower()
    system = {"linux": "linux", "win32": "windows", "darwin": "macos"}.get(sys.platform, "")
    kind = {"x86_64": "x64", "amd64": "x64", "arm64": "arm64", "aarch64": "arm64"}.get(machine, "")
    name = f"{system}-{kind}"
    return name if name in PLATFORMS else None


def version() -> str:
    """Return the version of the wheels: of another interface, another one, or Blender would keep the old library."""
    found = re.search('^version = "(.+)"', (ROOT / "blender_manifest.toml").read_text(), re.MULTILINE)
    abi = re.search(r"^#define DM_ABI (\d+)", (SOURCES / "dimple.h").read_text(), re.MULTILINE)
    assert found and abi
    return f"{found[1]}.post{abi[1]}"


def compile_library(python: str | Path, name: str, *more: str) -> Path:
    """Return the library of a platform, compiled when a source or a pin is newer.

    Args:
        more: options for the compiler; such a library lies in a place of its own.

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
    words: list[list[str | Path]] = [
        [FUSE[64], *([SMALL] if each in ONCE_SMALL else ()), SOURCES / f"{each}.c", "-o", folder / f"{each}.o"]
        for each in ONCE
    ]
    for kind in target.sets:
        for bits in (32, 64) if DOUBLE in more else (32,):
            options: list[str | Path] = [f"-DDM_BITS={bits}", f"-DDM_SET={kind}", *VARIANTS[kind], FUSE[bits]]
            options += [SMALL] if kind != target.sets[-1] else []
            words.append([*options, SOURCES / "variant.c", "-o", folder / f"{kind}{bits}.o"])
    command: list[str | Path] = [zig, "cc", "-target", target.triple, *more]
    command += () if name.startswith("windows") else NO_UNWINDING
    command += () if "base" in target.sets else ["-DDM_NO_BASE"]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda rest: quiet([*command, *FLAGS, "-c", *rest]), words))
    objects = [rest[-1] for rest in words]
    system = ["-lm", "-lpthread"] if name.startswith("linux") else []
    quiet([*command, SMALL, "-shared", "-s", "-o", library, *objects, *system])
    stamp.write_text(sources_hash())
    return library


def compiler(python: str | Path) -> Path:
    """Return zig, installed first where it is not the pinned one.

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


def wheel_content(tag: str, library: dict[str, bytes]) -> bytes:
    """Return a wheel with one package of data, the same bytes whenever it is made."""
    info = f"{PACKAGE}-{version()}.dist-info"
    kind = f"Wheel-Version: 1.0\nGenerator: dimple\nRoot-Is-Purelib: false\nTag: py3-none-{tag}\n"
    metadata = f"Metadata-Version: 2.1\nName: {PACKAGE}\nVersion: {version()}\nLicense: GPL-3.0-or-later\n"
    files = {
        f"{PACKAGE}/__init__.py": b'"""The compiled core of Dimple."""\n',
        **{f"{PACKAGE}/{name}": content for name, content in library.items()},
        f"{info}/METADATA": metadata.encode(),
        f"{info}/WHEEL": kind.encode(),
    }
    record = "".join(f"{name},sha256={_digest(content)},{len(content)}\n" for name, content in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    return min((_zipped(files, *each) for each in ((4, 0, 0), (0, 2, 2))), key=len)  # for x86, for arm


def _zipped(files: dict[str, bytes], lc: int, lp: int, pb: int) -> bytes:
    """Return a zip of files, packed by LZMA with so many bits of the byte before, of the place, and of that again.

    A fifth smaller, and every Python of Blender reads it.
    """

    def begun(packer: Any) -> bytes:
        packer._comp = lzma.LZMACompressor(lzma.FORMAT_RAW, filters=[{"id": lzma.FILTER_LZMA1, **options}])
        return struct.pack("<BBHBL", 9, 4, 5, (pb * 5 + lp) * 9 + lc, options["dict_size"])

    options = {"lc": lc, "lp": lp, "pb": pb, "dict_size": 1 << 23}
    memory = io.BytesIO()
    with mock.patch("zipfile.LZMACompressor._init", begun), zipfile.ZipFile(memory, "w") as archive:
        for name, content in files.items():
            kind = zipfile.ZIP_LZMA if len(content) > SHORT else zipfile.ZIP_DEFLATED
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content, kind, 9)
    return memory.getvalue()


def _digest(content: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
