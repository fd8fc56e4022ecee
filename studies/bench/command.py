"""`dev.py core emulator`: an emulated haptic device behind a pseudo-terminal or on UDP, with faults and a trace.

Standard library only: start.py runs it without site-packages.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import secrets
import signal
import sys
from pathlib import Path

from core.device import wire
from core.device.process import SECRET
from core.errors import DimpleError

from . import pseudo_terminal
from .faults import FAULTS, InjectedFault, parse_fault
from .faulty_emulator import FaultyEmulator, SessionRoundTrips, TraceRow
from .hand import load_hand, poking_hand
from .haply_service import HaplyService, run_service
from .network import DeviceLine
from .numbers import BITS_A_BYTE, load_emulated
from .round_trips import percentiles

MODES = ("idle", "arming", "ramp", "armed", "brake", "fault")
COLUMNS = (
    "t_s",
    "mode",
    *(f"{axis}{i}_m" for i in "123" for axis in "xyz"),
    *(f"f{axis}{i}_n" for i in "123" for axis in "xyz"),
)


def add_emulator(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    command.set_defaults(run=run_emulator)
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = "faults, as NAME[-in|-out][=VALUE][@START[+LENGTH]], seconds:\n" + "\n".join(
        f"  {name:<11} {text} ({value:g})" for name, (value, text) in FAULTS.items()
    )
    port = command.add_mutually_exclusive_group(required=True)
    port.add_argument("--pty", type=Path, metavar="PATH", help="path of the port to create")
    port.add_argument("--udp", type=int, metavar="PORT", help="serve a host on this computer that knows the secret")
    port.add_argument("--haply", type=int, metavar="PORT", help="serve as Haply's service does for three Inverse3")
    command.add_argument("--device", type=Path, metavar="TOML", help="device file; default: the Haptic Master's")
    command.add_argument("--hand", type=Path, metavar="JSON", help="what holds the device; default: a hand that pokes")
    command.add_argument(
        "--fault", action="append", default=[], metavar="FAULT", help="fault to inject; may be repeated"
    )
    command.add_argument("--seconds", type=float, metavar="N", default=math.inf, help="end after N seconds")
    command.add_argument("--baud", type=int, metavar="B", help="bits per second; 0: bytes take no time")
    command.add_argument("--seed", type=int, default=0, help="of all random numbers")
    command.add_argument("--json", type=Path, metavar="OUT", help="write at the end what the device measured")
    command.add_argument("--lifeline", action="store_true", help="end when standard input closes")
    command.add_argument("--trace", type=Path, metavar="OUT.csv", help="write each tick: true positions and forces")


def run_emulator(options: argparse.Namespace) -> int:
    """Run a device, print where its port is, and at the end what it measured."""
    trace: list[TraceRow] | None = [] if options.trace else None
    faults = [parse_fault(text) for text in options.fault]
    if options.seconds < math.inf:
        faults.append(InjectedFault("unplug", 1.0, start=options.seconds))
    if options.haply:
        return _run_service(options)
    emulator = FaultyEmulator(
        load_emulated(options.device),
        hand=load_hand(options.hand) if options.hand else poking_hand(),
        faults=faults,
        seed=options.seed,
        baud=options.baud,
        trace=trace,
    )
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: setattr(emulator, "unplugged", True))
    lifeline = sys.stdin.fileno() if options.lifeline else None
    if options.pty:
        served = pseudo_terminal.serve(emulator, options.pty, lifeline=lifeline)
    else:
        secret = os.environ.get(SECRET) or secrets.token_hex(16)
        line = DeviceLine(options.udp, secret)
        print(f"{emulator.spec.name} (emulated) at udp:127.0.0.1:{options.udp}, its secret: {secret}", flush=True)
        served = pseudo_terminal.run(emulator, line.fileno(), lifeline, line.read, line.write)
        line.close()
    record = {
        **measured(emulator),
        "real_time": float(served.real_time),
        "slips": float(served.slips),
        "slipped_s": served.slipped,
        "overflows": float(served.overflows),
    }
    print(json.dumps(record), file=sys.stderr)
    try:
        if options.json:
            options.json.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
        if options.trace and trace is not None:
            with options.trace.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([COLUMNS, *trace])
    except OSError as error:
        raise DimpleError(f"{error.filename} cannot be written: {error.strerror}.") from None
    return 0


def _run_service(options: argparse.Namespace) -> int:
    """Run a Haply service until its lifeline closes."""
    trace: list[TraceRow] = []
    hand = load_hand(options.hand) if options.hand else poking_hand()
    service = HaplyService(options.haply, load_emulated(options.device), hand=hand, trace=trace)
    print(f"Three Inverse3 (emulated) at haply:{options.haply}", flush=True)
    granted = run_service(service, sys.stdin.fileno() if options.lifeline else None, options.seconds)
    if options.json:
        late = sum(gap > service.spec.tick for gap in service.gaps) / max(len(service.gaps), 1)
        record = dict(zip(("rtt_p50_us", "rtt_p99_us", "rtt_max_us"), percentiles(service.gaps), strict=True))
        record = {name: 1e6 * gap for name, gap in record.items()}
        record |= {"real_time": float(granted), "late_share": late, "wire_us": 0.0, "lost": 0.0, "bad": 0.0}
        options.json.write_text(json.dumps(record), encoding="utf-8")
    if options.trace:
        with options.trace.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([COLUMNS, *trace])
    return 0


def measured(emulator: FaultyEmulator) -> dict[str, float | str]:
    """Return what the device measured of its last session, on its own clock."""
    link, firmware = emulator.firmware.link, emulator.firmware
    record: dict[str, float | str] = {"mode": MODES[firmware.mode], "fault": firmware.code, "ticks": 0}
    if isinstance(link, SessionRoundTrips) and link.ticks:
        bits = BITS_A_BYTE * (wire.size(wire.DeviceState) + wire.size(wire.Command))
        record |= {name: getattr(link, name) for name in ("answered", "stale", "lost")}
        record |= {"bad": emulator.decoder.refused, "wire_us": 1e6 * bits / emulator.baud if emulator.baud else 0}
        names = ("rtt_p50_us", "rtt_p99_us", "rtt_max_us")  # of the whole session, not of its last second
        record |= dict(zip(names, percentiles(link.trips.elements()), strict=True))
        # ticks after the host's last answer are not late answers
        record |= {"ticks": link.ticks, "late_share": 1 - link.in_time / link.heard if link.heard else 1.0}
    record["protocol"] = ".".join(map(str, wire.PROTOCOL))
    return record
