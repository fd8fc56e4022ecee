#!/usr/bin/env python3
"""Build, test and measure Dimple from a fresh clone: `python3 dev.py COMMAND`.

It needs Python 3.11 or 3.13 and the package registries, nothing else: each command first makes the environment that
it needs (tools/environment.py).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from tools import native as native_core
from tools.environment import BLENDERS, OLDEST, ROOT, Stop, environment, provide_peers, run, run_together, say
from tools.extension import build_zip

BUILD = ROOT / "build"
# what runs by the real clock, with a device's processes, runs alone, then the rest in parts, as many at a time as there
# are processors; they begin in an order in which two end together
BY_THE_CLOCK = "byte_poller", "device", "mailbox", "processes", "pseudo_terminal", "serial_line", "udp_line"
REAL_TIME = [f"tests/haptics/test_{name}.py" for name in BY_THE_CLOCK]
BLENDERS_OWN = ["tests/blender"]
LONG = ["tests/calibration", "tests/experiment", "tests/studies", "tests/unit"]
SANITIZED = ["tests/parity/test_sanitizers.py"]
OTHERS = ["tests", *(f"--ignore={place}" for place in (*REAL_TIME, *LONG, *BLENDERS_OWN, *SANITIZED))]
TESTS_LIMIT_S = 1800  # Blender 4.5 hangs at exit when a timer is left registered
SCRIPT_LIMIT_S = 1800
NO_TESTS_COLLECTED = 5  # pytest's exit code


# the commands: each takes the parsed options and returns an exit code


def demo(options: argparse.Namespace) -> int:
    """press the samples in Blender; write pictures, curves, animations and a summary"""
    return in_blender("blend_samples/demo.py", options.blender, options.out or BUILD / "demo")


def window(options: argparse.Namespace) -> int:
    """press a mesh in a real Blender window, with a simulated mouse; names of scenes play only those"""
    return in_blender("tests/window/run.py", options.blender, options.out or BUILD / "window", *options.rest)


def samples(options: argparse.Namespace) -> int:
    """make blend_samples/*.blend again, in the oldest Blender so that every version opens them, and addon/pictures"""
    return in_blender("blend_samples/make_samples.py", options.blender or OLDEST, None)


def in_blender(script: str, wanted: str | None, out: Path | None, *words: str) -> int:
    """Run a script that installs the freshly built zip into a throwaway Blender profile."""
    python = environment(wanted)
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        command = [python, script, "--zip", build_zip(python, BUILD)]
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
            command += ["--out", out.resolve()]
        command += words
        return run(command, limit_s=SCRIPT_LIMIT_S, BLENDER_USER_RESOURCES=profile)


def test(options: argparse.Namespace) -> int:
    """run the tests; paths and further options go to pytest; of a second --blender what depends on Blender"""
    python, *others = [environment(wanted) for wanted in options.blender or [None]]
    native_core.provide_library(python)
    paths = [word for word in options.rest if Path(word).parts[:1] == ("tests",)]
    flags = [*(["-m", ""] if options.slow else []), *(word for word in options.rest if word not in paths)]
    # core and the installed extension are the same modules under two names: one process never holds both
    inside = [path for path in paths if Path(path).parts[:2] == ("tests", "blender")]
    outside = [path for path in paths if path not in inside]
    own = inside if paths else BLENDERS_OWN
    once = [] if "-m" in flags and not options.slow else ["-m", "not once" if options.slow else "not slow and not once"]
    theirs = [(other, [*once, *own]) for other in others if own]
    parts = [(python, own), (python, LONG), *theirs, (python, OTHERS), (python, SANITIZED)]
    codes = []
    for some in ([(python, outside), (python, own), *theirs],) if paths else ([(python, REAL_TIME)], parts):
        commands = [[each, "-m", "pytest", *flags, *places] for each, places in some if places]
        codes += run_together(commands, limit_s=TESTS_LIMIT_S)
    if all(code == NO_TESTS_COLLECTED for code in codes):
        return NO_TESTS_COLLECTED
    return next((code for code in codes if code not in (0, NO_TESTS_COLLECTED)), 0)


def lint(options: argparse.Namespace) -> int:
    """check the sources with ruff and mypy"""
    python = environment(options.blender)
    mypy = [python, "-m", "mypy", "-p", "core", "-p", "studies", "-p", "tools"]
    return run([python, "-m", "ruff", "check", "."]) or run(mypy)


def build(options: argparse.Namespace) -> int:
    """validate the extension and build its zip"""
    path = build_zip(environment(options.blender), options.out or BUILD)
    say(f"built {path} ({path.stat().st_size / 1e6:.2f} MB)")
    return 0


def native(options: argparse.Namespace) -> int:
    """compile the native core for this machine, into core/native/"""
    native_core.provide_library(environment(options.blender))
    return 0


def wheels(options: argparse.Namespace) -> int:
    """compile the native core for every platform, and build one zip for each"""
    python, out = environment(options.blender), options.out or BUILD / "platforms"
    made = [*native_core.provide_wheels(python), build_zip(python, out, split=True)]
    for path in sorted({*made, *out.glob("*.zip")}):
        say(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")
    return 0


def bench(options: argparse.Namespace) -> int:
    """measure what steps and sessions cost; --quick, --json FILE, --profile, --peers, --scale, --exports"""
    asks = {"-h", "--help"} & {*options.rest}  # of all kinds together
    if "--exports" in options.rest and not asks:
        return in_blender("tests/bench/exports.py", options.blender, BUILD / "exports")
    python = environment(options.blender)
    native_core.provide_library(python)
    variables = {"OPENBLAS_NUM_THREADS": "1"}
    if "--peers" in options.rest:
        variables["PYTHONPATH"] = str(provide_peers(python))
    return run([python, "-m", "tests.bench.bench", *options.rest], **variables)


def charts(options: argparse.Namespace) -> int:
    """draw the charts of the studies and print which method is the cheapest; --quick for smaller bodies"""
    out = (options.out or BUILD / "charts").resolve()
    return run([environment(options.blender), "-m", "tools.charts", "--out", out, *options.rest])


def contact(options: argparse.Namespace) -> int:
    """judge twelve scenes in which nothing may pass through anything; --quick, --json FILE"""
    paths = [str(Path(word).resolve()) if before == "--json" else word
             for before, word in zip(["", *options.rest], options.rest, strict=False)]  # fmt: skip
    python = environment(options.blender)
    native_core.provide_library(python)
    return run([python, "-m", "studies.contact", *paths])


def core(options: argparse.Namespace) -> int:
    """run a study without Blender, such as calibrate, paper, dents, haptics; `core --help` lists them"""
    python = environment(options.blender)
    native_core.provide_library(python)
    return run([python, "-m", "studies", *options.rest])


def bake(options: argparse.Namespace) -> int:
    """simulate bodies of a .blend file and export what they do, as `blender --command dimple bake` does"""
    python = environment(options.blender)
    native_core.provide_library(python)
    paths = {at + 1 for at, word in enumerate(options.rest) if word in ("--out", "--json")}  # from where one stands
    is_path = [at in paths or Path(word).is_file() for at, word in enumerate(options.rest)]
    words = [str(Path(word).resolve()) if path else word for word, path in zip(options.rest, is_path, strict=True)]
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        command = [python, "tools/bake.py", "--zip", build_zip(python, Path(profile)), *words]
        return run(command, BLENDER_USER_RESOURCES=profile)


def ci(_options: argparse.Namespace) -> int:
    """run what continuous integration runs: .ci/run"""
    return run(["bash", ".ci/run"])


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="dev.py", description=(__doc__ or "").partition("\n")[0])
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for action in (demo, test, lint, build, native, wheels, bench, charts, window, samples, core, contact, bake, ci):
        own_help = action not in (bench, charts, core, contact, bake)  # what they run has a help of its own
        text = action.__doc__
        command = commands.add_parser(
            action.__name__, help=text, description=text, allow_abbrev=False, add_help=own_help
        )
        command.set_defaults(action=action, out=None)
        several = {"action": "append"} if action is test else {}
        versions = f"{', '.join(BLENDERS)}, or its first numbers"
        command.add_argument("--blender", metavar="VERSION", help=versions, **several)
        if action is test:
            command.add_argument("--slow", action="store_true", help="run the slow tests too")
        if action in (demo, build, wheels, charts, window):
            command.add_argument("--out", type=Path, metavar="DIR", help="where the results go")
    options, options.rest = parser.parse_known_args(words)
    if options.rest and options.action not in (test, core, contact, bench, charts, bake, window):
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
