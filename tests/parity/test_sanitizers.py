"""The whole parity suite once more, on a library that stops at the first bad access or undefined operation."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tools.native import DOUBLE, ONCE, SOURCES, VARIANTS

STRICT = ("-Wall", "-Wextra", "-Werror")  # in gcc too nothing is warned of
SANITIZE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")
EXACT = ("-fno-math-errno", "-ffp-contract=off")
FLAGS = ("-std=c11", "-O0", "-g", "-fPIC", "-fvisibility=hidden", DOUBLE, *EXACT, *STRICT)


def compiled(folder: Path) -> Path:
    """Compile the sources as the extension does, but with gcc and its sanitizers."""
    running = [
        [*FLAGS, *SANITIZE, "-c", SOURCES / f"{each}.c", "-o", folder / f"{each}.o"] for each in ONCE
    ]
    for kind, options in VARIANTS.items():
        for bits in (32, 64):
            named = [f"-DDM_BITS={bits}", f"-DDM_SET={kind}", "-o", folder / f"{kind}{bits}.o"]
            running.append([*FLAGS, *SANITIZE, *options, "-c", SOURCES / "variant.c", *named])
    started = [subprocess.Popen(["gcc", *words]) for words in running]
    assert [process.wait() for process in started] == [0] * len(started)
    library = folder / "libdimple_core.so"
    subprocess.run(["gcc", "-shared", *SANITIZE, "-o", library, *folder.glob("*.o"), "-lm", "-lpthread"], check=True)
    return library


def test_address_and_undefined_behaviour_sanitizers_find_nothing(tmp_path: Path) -> None:
    if "DIMPLE_LIBRARY" in os.environ:
        pytest.skip("this is that run")
    if sys.platform != "linux" or os.uname().machine != "x86_64" or not shutil.which("gcc"):
        pytest.skip("needs gcc on Linux")
    runtime = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True).stdout.strip()
    if not Path(runtime).is_absolute():
        pytest.skip("gcc has no sanitizers here")
    done = subprocess.run(
        [
            sys.executable, "-m", "pytest", "-q", "-s", "-x", "-k", "not numpy]",
            "-o", f"cache_dir={tmp_path / 'cache'}", Path(__file__).parent,
        ],
        env={
            **os.environ, "DIMPLE_LIBRARY": str(compiled(tmp_path)), "LD_PRELOAD": runtime,
            "ASAN_OPTIONS": "detect_leaks=0",  # Python's own
        },
        capture_output=True, text=True, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert " passed" in done.stdout
