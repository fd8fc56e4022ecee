"""`dev.py core haptics`: a scripted press of three fingers, rendered through the real driver, servo and session.

The device is emulated, in a process of its own behind a pseudo-terminal; what it did is judged by its own trace, not
by the servo's report.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
import time
from pathlib import Path

import numpy as np

from core.base import DimpleError
from core.body.model import build_model
from core.device.force_guard import Arming
from core.device.orders import LinkState, ServoReport
from core.device.workspace import fingers, surfaces_of
from core.mesh.surface import base_vertices
from core.session import Session
from studies.bench.processes import EmulatedDevice
from studies.device.machine_lateness import machine_lateness
from studies.device.scripted_press import (
    CYCLE,
    PRESET,
    RADIUS,
    READY_AFTER,
    SHORTEST,
    WORKSPACE,
    PressRecord,
    judge,
    way,
)
from studies.files import write_json
from studies.scenes import cube

FRAME = 1 / 60  # [s]
STALL, STALL_EVERY = 0.200, 1.0  # [s] of Blender's main thread
CONNECT = 5.0  # [s] at most
CELLS = 8  # of the cube along an edge


def add_haptics(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_haptics)
    command.add_argument("--emulate", action="store_true", required=True, help="with an emulated device")
    command.add_argument(
        "--seconds", type=float, default=10.0, metavar="N", help=f"of pressing, {SHORTEST:.2f} at least"
    )
    command.add_argument("--busy", action="store_true", help="stall the main thread for 200 ms each second")
    command.add_argument("--fault", action="append", default=[], metavar="FAULT", help="see `emulator --help`")
    command.add_argument("--baud", type=int, metavar="B", help="bits a second, 0: bytes take no time")
    command.add_argument("--udp", action="store_true", help="by UDP in place of a pseudo-terminal")
    command.add_argument("--json", type=Path, metavar="OUT", help="write the figures")


def run_haptics(options: argparse.Namespace) -> int:
    """Press, then print the figures."""
    words = [word for fault in options.fault for word in ("--fault", fault)]
    words += [] if options.baud is None else ["--baud", str(options.baud)]
    machine = machine_lateness()
    record = press(options.seconds, busy=options.busy, words=words, udp=options.udp)
    figures = {**judge(record), **machine}
    if record.report.arming is not Arming.ON:
        print(f"Not armed at the end, so forces and stiffness are too small. {record.report.note}")
    if not figures["real_time"]:
        print("This account has no real-time priority, so device and servo wait for other processes now and then.")
    print("\n".join(f"{name:<22} {value:.6g}" for name, value in figures.items()))
    if options.json:
        write_json(options.json, figures)
    return 0


def press(seconds: float, *, busy: bool = False, words: list[str] | None = None, udp: bool = False) -> PressRecord:
    """Press a cube with three fingers for some seconds [s].

    Args:
        busy: the main thread stalls for STALL each second.
        words: more options of the emulator.
        udp: the device is on the network of this computer.

    Raises:
        DimpleError: the device does not connect or does not arm, or the time is too short for one press.
    """
    cycles = math.floor((seconds - READY_AFTER) / CYCLE + 1e-9)
    if cycles < 1:
        raise DimpleError(f"A press takes {SHORTEST:.2f} s: give --seconds at least that.")
    with tempfile.TemporaryDirectory(prefix="dimple-") as folder:
        trace, measured, log = (Path(folder) / name for name in ("trace.csv", "device.json", "log.csv"))
        device = EmulatedDevice(
            hand=json.dumps({"tips": [way(i, cycles) for i in range(3)]}),
            held_until=math.inf,
            udp=udp,
            emulator_words=["--trace", str(trace), "--json", str(measured), *(words or [])],
            servo_words=["--log", str(log)],
        )
        frames: list[tuple[float, float]] = []
        mesh = cube(CELLS, PRESET.size)
        session = Session(build_model(mesh, [PRESET.material], pinned=base_vertices(mesh)))
        try:
            device.open()
            report = _drive(device, session, seconds, busy, frames)
        finally:
            device.close()
        if not (trace.exists() and measured.exists() and log.exists()):
            raise DimpleError("Device or servo did not end in time, so there is no trace: this computer is too busy.")
        rows = np.loadtxt(trace, delimiter=",", skiprows=1, ndmin=2)
        answers = np.loadtxt(log, delimiter=",", ndmin=2)
        return PressRecord(cycles, report, json.loads(measured.read_text()), rows, answers, np.array(frames))


def _drive(
    device: EmulatedDevice, session: Session, seconds: float, busy: bool, frames: list[tuple[float, float]]
) -> ServoReport:
    """Step session and device together, as Blender does: 60 times a second."""
    armed = 0.0
    begun = last = stalled = time.perf_counter()
    while not armed or time.perf_counter() - armed < seconds:
        report = device.read()
        if report.link in (LinkState.REFUSED, LinkState.LOST) or (not armed and time.perf_counter() - begun > CONNECT):
            raise DimpleError(report.note or "The emulated device did not arm.")
        now = time.perf_counter()
        if report.link is LinkState.READY:
            session.set_fingers(fingers(report, WORKSPACE, RADIUS))
            touches, shown = session.step(min(now - last, 2 * FRAME)).touches, time.perf_counter()
            device.write(surfaces_of(session, touches, WORKSPACE, shown))
            if report.arming is Arming.OFF and not armed:
                device.arm()
            armed = armed or (now if report.arming in (Arming.RAMP, Arming.ON) else 0.0)
            frames.append((now, report.cap))
        last = now
        if busy and now - stalled > STALL_EVERY:
            stalled = now
            while time.perf_counter() - now < STALL:
                pass
        time.sleep(max(FRAME - (time.perf_counter() - now), 0.0))
    return report
