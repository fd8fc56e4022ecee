"""`dev.py core haptics`: a scripted press of three fingers, rendered through the real driver, servo and session.

The device is emulated, in a process of its own behind a pseudo-terminal; what it did is judged by its own trace, not
by the servo's report.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
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
from studies.device.scripted_press import LEVELS, PRESET, RADIUS, READY_AFTER, WORKSPACE, PressRecord, cycle, judge, way
from studies.files import write_json
from studies.scenes import cube

FRAME = 1 / 60  # [s]
STALL, STALL_EVERY = 0.200, 1.0  # [s] of Blender's main thread
CONNECT = 5.0  # [s] at most
CELLS = 8  # of the cube along an edge
LINES = ("pty", "udp", "haply")
DEPTHS = (0.001, 0.002, 0.004, 0.008, 0.015)  # [m] at which the table compares the force with the law


def add_haptics(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_haptics)
    command.add_argument("--emulate", action="store_true", required=True, help="with an emulated device")
    shortest = READY_AFTER + cycle()
    command.add_argument("--seconds", type=float, metavar="N", help=f"time to press, at least {shortest:.2f}")
    command.add_argument("--busy", action="store_true", help="stall the main thread for 200 ms each second")
    command.add_argument("--fault", action="append", default=[], metavar="FAULT", help="see `emulator --help`")
    command.add_argument("--baud", type=int, metavar="B", help="bits per second; 0: bytes take no time")
    command.add_argument("--line", choices=LINES, default="pty", help="how it is connected")
    command.add_argument("--table", action="store_true", help="press over every line, without and with two busy loops")
    command.add_argument("--json", type=Path, metavar="OUT", help="write the figures")


def run_haptics(options: argparse.Namespace) -> int:
    """Press, then print the figures."""
    if options.table:
        return _print_table(options.seconds or 60.0)
    words = [word for fault in options.fault for word in ("--fault", fault)]
    words += [] if options.baud is None else ["--baud", str(options.baud)]
    machine = machine_lateness()
    record = press(options.seconds or 10.0, busy=options.busy, words=words, line=options.line)
    figures = {**judge(record), **machine}
    if record.report.arming is not Arming.ON:
        print(f"Not armed at the end, so forces and stiffness are too small. {record.report.note}")
    if not figures["real_time"]:
        print("This account has no real-time priority, so device and servo wait for other processes now and then.")
    print("\n".join(f"{name:<22} {value:.6g}" for name, value in figures.items()))
    if options.json:
        write_json(options.json, figures)
    return 0


def _print_table(seconds: float) -> int:
    """Print a row for each line and load: at depths held by a rigid hand, then with stalls of the main thread."""
    names = [f"law_at_{1e3 * depth:g}_mm" for depth in DEPTHS]
    over = " ".join(f"{1e3 * depth:4.0f}" for depth in DEPTHS)
    print("                    late alone   rate     p50     p99   late   cap   force over law at mm         energy of")
    print(f"line   loops            [%]   [Hz]    [us]    [us]    [%] [N/m]  {over}   {seconds:.0f} s [mJ]")
    for line in LINES:
        for loads in (0, 2):
            alone = 100 * machine_lateness()["machine_late_share"]
            try:
                still = judge(press(READY_AFTER + cycle(DEPTHS), line=line, loads=loads, levels=DEPTHS, rigid=True))
                stalled = judge(press(seconds, line=line, loads=loads, busy=True))
            except DimpleError as error:
                print(f"{line:<6} {loads:5}      {alone:9.2f}   {error}", flush=True)
                continue
            law = " ".join(f"{still[name]:4.2f}" for name in names)
            print(f"{line:<6} {loads:5}      {alone:9.2f}  {still['rate_hz']:5.0f}  {still['rtt_p50_us']:6.0f}  "
                  f"{still['rtt_p99_us']:6.0f} {100 * still['late_share']:6.2f} {still['stiffness_cap_n_m']:5.0f}  "
                  f"{law}  {stalled['energy_mj']:8.2f}", flush=True)  # fmt: skip
    return 0


def press(
    seconds: float, *, busy: bool = False, words: list[str] | None = None, loads: int = 0, line: str = "pty",
    levels: tuple[float, ...] = LEVELS, rigid: bool = False,
) -> PressRecord:  # fmt: skip
    """Press a cube with three fingers for some seconds [s].

    Args:
        busy: the main thread stalls for STALL each second.
        words: more options of the emulator.
        loads: other processes that only compute.
        line: how the device is connected, see `EmulatedDevice`.
        levels: how deep the hand wants each hold [m].
        rigid: the hand yields to no force.

    Raises:
        DimpleError: the device does not connect or does not arm, or the time is too short for one press.
    """
    cycles = math.floor((seconds - READY_AFTER) / cycle(levels) + 1e-9)
    if cycles < 1:
        raise DimpleError(f"A press takes {READY_AFTER + cycle(levels):.2f} s: give --seconds at least that.")
    with tempfile.TemporaryDirectory(prefix="dimple-") as folder:
        hand = {"tips": [way(i, cycles, levels) for i in range(3)]}
        trace, measured, log = (Path(folder) / name for name in ("trace.csv", "device.json", "log.csv"))
        device = EmulatedDevice(
            hand=json.dumps(hand | ({"stiffness": None} if rigid else {})),
            held_until=math.inf,
            line=line,
            emulator_words=["--trace", str(trace), "--json", str(measured), *(words or [])],
            servo_words=["--log", str(log)],
        )
        frames: list[tuple[float, float]] = []
        mesh = cube(CELLS, PRESET.size)
        session = Session(build_model(mesh, [PRESET.material], pinned=base_vertices(mesh)))
        others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(loads)]
        try:
            device.open()
            report = _drive(device, session, seconds, busy, frames)
        finally:
            device.close()
            for other in others:
                other.kill()
        if not (trace.exists() and measured.exists() and log.exists()):
            raise DimpleError("Device or servo did not end in time, so there is no trace: this computer is too busy.")
        rows = np.loadtxt(trace, delimiter=",", skiprows=1, ndmin=2)
        answers = np.loadtxt(log, delimiter=",", ndmin=2)
        return PressRecord(cycles, levels, report, json.loads(measured.read_text()), rows, answers, np.array(frames))


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
