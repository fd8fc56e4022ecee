"""The command line of the two processes that Blender starts (start.py): the servo, and the emulated device to try."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from ..errors import DimpleError
from . import pseudo_terminal, servo_process
from .emulated_hand import load_hand
from .emulator import Emulator
from .servo import Servo
from .spec import load_spec


def main(words: list[str]) -> int:
    """Run one of the two until standard input closes; return its exit code."""
    return run(words, servo=add_servo, emulator=add_emulator)


def run(words: list[str], **processes: Callable[[argparse.ArgumentParser], None]) -> int:
    """Run the process that the first word names and return its exit code; processes: what adds the options of each."""
    parser = argparse.ArgumentParser(prog="start.py")
    commands = parser.add_subparsers(required=True)
    for name, add_options in processes.items():
        add_options(commands.add_parser(name))
    options = parser.parse_args(words)
    try:
        return int(options.run(options))
    except DimpleError as error:
        print(error, file=sys.stderr)
        return 2


def add_servo(command: argparse.ArgumentParser) -> None:
    """Add the options of the servo."""
    command.set_defaults(run=run_servo)
    command.add_argument("port", help="serial port, or the path of a pseudo-terminal")
    command.add_argument("--mailbox", type=Path, required=True, metavar="FILE", help="made by Blender")
    command.add_argument("--device", type=Path, metavar="TOML", help="device file, if not the Haptic Master's")


def add_emulator(command: argparse.ArgumentParser) -> None:
    """Add the options of the emulated device."""
    command.set_defaults(run=run_emulator)
    command.add_argument("--pty", type=Path, metavar="PATH", required=True, help="where the port is to be")
    command.add_argument("--device", type=Path, metavar="TOML", help="device file, if not the Haptic Master's")
    command.add_argument("--hand", type=Path, metavar="JSON", help="what holds the device, if not a hand at rest")


def run_servo(options: argparse.Namespace) -> int:
    """Run the servo."""
    return servo_process.run(Servo, options.port, options.mailbox, options.device)


def run_emulator(options: argparse.Namespace) -> int:
    """Run the emulated device."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    emulator = Emulator(load_spec(options.device), hand=load_hand(options.hand) if options.hand else None)
    pseudo_terminal.serve(emulator, options.pty, lifeline=sys.stdin.fileno())
    return 0
