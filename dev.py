#!/usr/bin/env python3
"""Build, test and measure Dimple from a fresh clone: `python3 dev.py COMMAND`.

It needs Python 3.11 or 3.13 and the package registries. Each command first makes the environment it needs
(tools/environment.py); `--help` needs none.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

from studies import commands as studies_commands
from studies.charts import __main__ as chart_drawing
from tests.bench import __main__ as benchmarks
from tools import native as native_core
from tools.environment import BLENDERS, OLDEST, ROOT, Stop, environment, provide_peers, run, run_together, say
from tools.extension import build_zip

BUILD = ROOT / "build"
# tests that measure real time with a device's processes run alone; then the other groups run side by side, one for each
# processor, the long ones first
REAL_TIME_FILES = "byte_poller", "device", "mailbox", "processes", "pseudo_terminal", "serial_line", "udp_line"
REAL_TIME = [f"tests/haptics/test_{name}.py" for name in REAL_TIME_FILES]
IN_BLENDER = ["tests/blender"]
LONG = ["tests/calibration", "tests/experiment", "tests/studies", "tests/unit"]
SANITIZED = ["tests/parity/test_sanitizers.py"]
OTHERS = ["tests", *(f"--ignore={path}" for path in (*REAL_TIME, *LONG, *IN_BLENDER, *SANITIZED))]
TESTS_LIMIT_S = 1800  # Blender 4.5 hangs at exit if a timer is still registered
SCRIPT_LIMIT_S = 7200  # all scenes of the window, drawn in software by a busy computer
NO_TESTS_COLLECTED = 5  # pytest's exit code


# the commands: each takes the parsed options and returns an exit code; the first line of its docstring is its help


def demo(options: argparse.Namespace) -> int:
    """press the samples in Blender; write pictures, curves, animations and a summary"""
    return in_blender("blend_samples/demo.py", options.blender, options.out or BUILD / "demo")


def window(options: argparse.Namespace) -> int:
    """press a mesh in a real Blender window with a simulated mouse; names of scenes choose which"""
    return in_blender("tests/window/run.py", options.blender, options.out or BUILD / "window", *options.rest)


def samples(options: argparse.Namespace) -> int:
    """make blend_samples/*.blend (in the oldest Blender, so that every version opens them) and addon/pictures"""
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
    """run the tests; paths and other options go to pytest; a second --blender runs only what depends on Blender"""
    python, *others = [environment(wanted) for wanted in options.blender or [None]]
    native_core.provide_library(python)
    paths = [word for word in options.rest if Path(word).parts[:1] == ("tests",)]
    flags = [*(["-m", ""] if options.slow else []), *(word for word in options.rest if word not in paths)]
    # core and the installed extension are the same modules under two names, so no process may load both
    inside = [path for path in paths if Path(path).parts[:2] == ("tests", "blender")] if paths else IN_BLENDER
    outside = [path for path in paths if path not in inside]
    once = [] if "-m" in flags and not options.slow else ["-m", "not once" if options.slow else "not slow and not once"]
    again = [(other, [*once, *inside]) for other in others if inside]
    if paths:
        rounds = [[(python, outside), (python, inside), *again]]
    else:
        groups = [(python, inside), (python, LONG), *again, (python, OTHERS), (python, SANITIZED)]
        rounds = [[(python, REAL_TIME)], groups]
    codes = []
    for groups in rounds:
        commands = [[each, "-m", "pytest", *flags, *places] for each, places in groups if places]
        codes += run_together(commands, limit_s=TESTS_LIMIT_S)
    failures = [code for code in codes if code not in (0, NO_TESTS_COLLECTED)]
    return failures[0] if failures else min(codes)


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
    """measure the cost of steps, sessions, drawing or exports"""
    asked = benchmarks.parser().parse_args(options.rest)
    if asked.exports:
        return in_blender("tests/bench/exports.py", options.blender, BUILD / "exports")
    peers = [provide_peers(environment(options.blender))] if asked.peers else []
    return module("tests.bench", options, *peers, OPENBLAS_NUM_THREADS="1")


def charts(options: argparse.Namespace) -> int:
    """draw speed against accuracy for every method, and print where each fails"""
    chart_drawing.parser().parse_args(options.rest)
    return module("studies.charts", options)


def core(options: argparse.Namespace) -> int:
    """run a study without Blender, such as calibrate or paper; `core --help` lists them"""
    if options.rest[:1] not in ([name] for name in studies_commands.COMMANDS):
        studies_commands.parser()[0].parse_args(options.rest)  # prints the list, or an error, and ends
    return module("studies", options)


def contact(options: argparse.Namespace) -> int:
    """short for `core contact`: judge thirteen scenes in which nothing may pass through anything"""
    options.rest = ["contact", *options.rest]
    return core(options)


def module(name: str, options: argparse.Namespace, *packages: Path, **variables: str) -> int:
    """Run a module of the repository in the user's current folder, to which relative paths in its options refer."""
    python = environment(options.blender)
    native_core.provide_library(python)
    path = os.pathsep.join(map(str, (ROOT, *packages)))
    return run([python, "-m", name, *options.rest], folder=Path.cwd(), PYTHONPATH=path, **variables)


def bake(options: argparse.Namespace) -> int:
    """simulate the bodies of a .blend file and export them, with the options of `blender --command dimple bake`"""
    python = environment(options.blender)
    native_core.provide_library(python)
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        command = [python, ROOT / "tools" / "bake.py", "--zip", build_zip(python, Path(profile)), *options.rest]
        return run(command, folder=Path.cwd(), BLENDER_USER_RESOURCES=profile)


def ci(_options: argparse.Namespace) -> int:
    """run what continuous integration runs: .ci/run"""
    return run(["bash", ".ci/run"])


COMMANDS = (demo, test, lint, build, native, wheels, bench, charts, window, samples, core, contact, bake, ci)
PASSED_ON = (bench, charts, core, contact, bake)  # all their options, --help included, go to the module that they run


def main(words: list[str]) -> int:
    options, options.rest = parser().parse_known_args(words)
    if options.rest and options.action not in (test, window, *PASSED_ON):
        parser().error(f"unknown arguments: {' '.join(options.rest)}")
    try:
        return options.action(options)
    except Stop as stop:
        say(str(stop))
        return 1
    except KeyboardInterrupt:
        return 130


def parser() -> argparse.ArgumentParser:
    whole = argparse.ArgumentParser(prog="dev.py", description=(__doc__ or "").partition("\n")[0])
    commands = whole.add_subparsers(metavar="COMMAND", required=True)
    for action in COMMANDS:
        text = action.__doc__
        own = action not in PASSED_ON
        command = commands.add_parser(action.__name__, help=text, description=text, allow_abbrev=False, add_help=own)
        command.set_defaults(action=action, out=None)
        several = {"action": "append"} if action is test else {}
        versions = f"{', '.join(BLENDERS)}, or the beginning of one"
        command.add_argument("--blender", metavar="VERSION", help=versions, **several)
        if action is test:
            command.add_argument("--slow", action="store_true", help="run the slow tests too")
        if action in (demo, build, wheels, window):
            command.add_argument("--out", type=Path, metavar="DIR", help="where the results go")
    return whole


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
