"""What can be done without Blender: `python3 dev.py core COMMAND`."""

from __future__ import annotations

import argparse
import sys
from importlib import import_module

from core.base import DimpleError

UNUSABLE, STOPPED = 2, 130  # exit codes; a command's own ones are 0 and from 3 on

# name: what it does, the module it lives in, and there the function that takes its parser and sets `run`;
# only the command asked for is imported
COMMANDS = {
    "calibrate": ("fit a material to a force-depth file", ".calibrate", "add_command"),
    "paper": ("reproduce the paper's tables and figures, beside the printed numbers", ".paper", "add_command"),
    "law": ("press and drag any mesh at random places: the force over the measured law", ".law", "add_law"),
    "emulator": ("run an emulated haptic device, with faults on demand", ".bench.command", "add_emulator"),
    "grasp": ("lift a cube with three emulated fingertips and put it down", ".grasp", "add_grasp"),
    "solid": ("press solids by finite elements, to compare bodies with", ".solid_report", "add_solid"),
    "release": ("press a hundred meshes, let go, and see what comes back", ".release_report", "add_release"),
    "dents": ("draw settled dents, measure how smooth they are and how they converge", ".dents", "add_dents"),
    "experiment": ("simulate or analyse the sensory comparison of chapter 5", ".experiment", "add_experiment"),
    "meeting": ("let bodies meet by their proxies and in full", ".meeting", "add_meeting"),
    "machines": ("compute what a graphics processor or many machines would bring", ".machines", "add_machines"),
    "haptics": ("press with an emulated device and print what it rendered", ".haptics", "add_haptics"),
}


def main(words: list[str] | None = None) -> int:
    """Run a command and return its exit code."""
    words = sys.argv[1:] if words is None else words
    parser = argparse.ArgumentParser(prog="dev.py core", description=__doc__)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, (text, module, add) in COMMANDS.items():
        command = commands.add_parser(name, help=text, allow_abbrev=False)
        if words[:1] == [name]:
            getattr(import_module(module, __package__), add)(command)
    options = parser.parse_args(words)
    try:
        return int(options.run(options))
    except DimpleError as error:
        print(error, file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        print("Stopped.", file=sys.stderr)
        return STOPPED


if __name__ == "__main__":
    sys.exit(main())
