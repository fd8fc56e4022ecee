"""`python -m core emulator`, a haptic device that is not there, and `servo`, what talks to any: both without numpy."""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
from pathlib import Path

from ..errors import DimpleError
from . import pseudo_terminal, server, wire
from .emulator import Emulator, Row
from .faults import FAULTS, parse_fault
from .hand import load_hand
from .spec import load_spec
from .watch import percentiles

MODES = ("idle", "arming", "ramp", "armed", "brake", "fault")
COLUMNS = (
    "t_s",
    "mode",
    *(f"{axis}{i}_m" for i in "123" for axis in "xyz"),
    *(f"f{a}{i}_n" for i in "123" for a in "xyz"),
)


def main(words: list[str]) -> int:
    """Run one of the two as a process of its own (start.py); return its exit code."""
    parser = argparse.ArgumentParser(prog="start.py")
    commands = parser.add_subparsers(required=True)
    add_servo(commands.add_parser("servo"))
    add_emulator(commands.add_parser("emulator"))
    options = parser.parse_args(words)
    try:
        return int(options.run(options))
    except DimpleError as error:
        print(error, file=sys.stderr)
        return 2


def add_servo(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=server.run)
    command.add_argument("port", help="serial port, or the path of a pseudo-terminal")
    command.add_argument("--mailbox", type=Path, required=True, metavar="FILE", help="that Blender made")
    command.add_argument("--baud", type=int, metavar="B", help="bits a second, if not the device's")
    command.add_argument("--device", type=Path, metavar="TOML", help="what it is, if not the Haptic Master")
    command.add_argument("--log", type=Path, metavar="OUT.csv", help="write each answer: places and forces")


def add_emulator(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_emulator)
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = "faults, as NAME[-in|-out][=VALUE][@START[+LENGTH]], seconds:\n" + "\n".join(
        f"  {name:<11} {text} ({value:g})" for name, (value, text) in FAULTS.items()
    )
    command.add_argument("--pty", type=Path, metavar="PATH", required=True, help="where the port is to be")
    command.add_argument("--device", type=Path, metavar="TOML", help="what it is, if not the Haptic Master")
    command.add_argument("--hand", type=Path, metavar="JSON", help="what holds it, if not a hand at rest")
    command.add_argument(
        "--fault", action="append", default=[], metavar="FAULT", help="what goes wrong; may be repeated"
    )
    command.add_argument("--seconds", type=float, metavar="N", default=math.inf, help="end after so long")
    command.add_argument("--baud", type=int, metavar="B", help="bits a second, 0: bytes take no time")
    command.add_argument("--seed", type=int, default=0, help="of all chance")
    command.add_argument("--json", type=Path, metavar="OUT", help="write at the end what the device measured")
    command.add_argument("--lifeline", action="store_true", help="end when standard input closes")
    command.add_argument("--trace", type=Path, metavar="OUT.csv", help="write each tick: true places and forces")


def run_emulator(options: argparse.Namespace) -> int:
    """Run a device and tell where its port is."""
    trace: list[Row] | None = [] if options.trace else None
    emulator = Emulator(
        load_spec(options.device),
        hand=load_hand(options.hand) if options.hand else None,
        faults=[parse_fault(text) for text in options.fault],
        seed=options.seed,
        baud=options.baud,
        trace=trace,
    )
    system = pseudo_terminal.serve(
        emulator, options.pty, options.seconds, lifeline=sys.stdin.fileno() if options.lifeline else None
    )
    told = {**measured(emulator), **system}
    print(json.dumps(told), file=sys.stderr)
    try:
        if options.json:
            options.json.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
        if options.trace and trace is not None:
            with options.trace.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([COLUMNS, *trace])
    except OSError as error:
        raise DimpleError(f"{error.filename} cannot be written: {error.strerror}.") from None
    return 0


def measured(emulator: Emulator) -> dict[str, float | str]:
    """Return what the device measured of its last session, on its own clock."""
    watch, firmware = emulator.firmware.watch, emulator.firmware
    told: dict[str, float | str] = {"mode": MODES[firmware.mode], "fault": firmware.code, "ticks": 0}
    if watch is not None and watch.ticks:
        report = watch.report(0, emulator.decoder.counts.refused, emulator.baud)
        told |= {name: getattr(report, name) for name in ("answered", "wire_us", "bad", "stale", "lost")}
        names = ("rtt_p50_us", "rtt_p99_us", "rtt_max_us")  # of the whole session, not of its last second
        told |= dict(zip(names, percentiles(watch.trips.elements()), strict=True))
        # when the host has hung up, nobody answers any more
        told |= {"ticks": watch.ticks, "late_share": 1 - watch.in_time / watch.heard if watch.heard else 1.0}
    told["protocol"] = ".".join(map(str, wire.PROTOCOL))
    return told
