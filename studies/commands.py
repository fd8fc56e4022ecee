"""The commands of `python3 dev.py core`. Nothing is imported here, so that `core --help` needs no environment."""

from __future__ import annotations

import argparse

# name: its purpose, its module, and the function there that declares its options and sets `run`
COMMANDS = {
    "calibrate": ("fit a material to a force-depth file", ".law.calibrate", "add_command"),
    "paper": ("reproduce the paper's tables and figures, beside the printed numbers", ".law.paper", "add_command"),
    "law": ("press and drag a mesh at random places: its force divided by the law", ".law.press_and_drag", "add_law"),
    "modes": ("compare how bodies sway and sag with finite elements", ".body.modes", "add_modes"),
    "release": ("press a hundred meshes, let go, and measure the shape that returns", ".body.release", "add_release"),
    "dents": ("measure how smooth settled dents are, and how close to finite elements", ".body.dents", "add_dents"),
    "solid": ("press solids by finite elements, for comparison", ".body.solid", "add_solid"),
    "contact": ("judge thirteen scenes in which nothing may pass through anything", ".contact.judge", "add_contact"),
    "led": ("lead shapes, whole and cut, into soft bodies: does the skin give way", ".contact.led", "add_led"),
    "props": ("let props rest on soft bodies: how deep, beside the closed form", ".contact.resting", "add_props"),
    "emulator": ("run an emulated haptic device, with faults on demand", ".bench.command", "add_emulator"),
    "haptics": ("press with an emulated device and print what it rendered", ".device.haptics", "add_haptics"),
    "grasp": ("lift a cube with three emulated fingertips and put it down", ".device.grasp", "add_grasp"),
    "experiment": ("simulate or analyse the sensory comparison of chapter 5", ".experiment.people", "add_experiment"),
}  # fmt: skip


def parser() -> tuple[argparse.ArgumentParser, dict[str, argparse.ArgumentParser]]:
    """Return the parser of all commands, and that of each command, as yet without its options."""
    whole = argparse.ArgumentParser(
        prog="dev.py core",
        description="Run a study without Blender; `dev.py core COMMAND --help` lists the options of a command.",
    )
    commands = whole.add_subparsers(metavar="COMMAND", required=True)
    parts = {
        name: commands.add_parser(name, help=purpose, allow_abbrev=False) for name, (purpose, *_) in COMMANDS.items()
    }
    return whole, parts
