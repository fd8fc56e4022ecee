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
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.base import DimpleError, Floats
from core.body.model import Model, build_model
from core.haptics.contact_rendering import ContactRendering, Workspace, fingers
from core.haptics.emulated_hand import Keyframe
from core.haptics.remote_body import Parcels, RemoteBody
from core.haptics.safety import Arming
from core.haptics.servo_messages import BodyState, LinkState, ServoReport
from core.haptics.wire import RAMP
from core.material import PRESETS
from core.mesh.surface import base_vertices
from core.session import Finger, Session

from .processes import InstrumentedDevice
from .scenes import cube

PRESET = PRESETS[1]  # vinyl and air: K1 = 610 N/m
RADIUS = 0.010  # [m] of the fingertips
APART = 0.040  # [m] of each from the middle of the top
CLEAR = 0.015  # [m] above the top, where a press begins
LEVELS = (0.005, 0.010, 0.015)  # [m] below the surface, where the hand wants its fingertips; they yield to the force
MOVE, HOLD, LIFT, SETTLE = 0.15, 0.40, 0.30, 0.10  # [s]
READY_AFTER = 1.3  # [s] from the beginning of the device's ramp until the servo's is over too
CYCLE = 2 * LIFT + len(LEVELS) * (MOVE + HOLD)
SHORTEST = READY_AFTER + CYCLE
WORKSPACE = Workspace(origin=(0.0, 0.0, PRESET.size / 2 + RADIUS))
FRAME = 1 / 60  # [s]
STALL, STALL_EVERY = 0.200, 1.0  # [s] of Blender's main thread
CONNECT = 5.0  # [s] at most
WRONG = 0.002  # [m] a position farther from the truth cannot be noise: its frame was wrong


@dataclass(frozen=True, slots=True)
class PressRecord:
    """The record of a scripted press.

    cycles: how often it pressed.
    report: the last of the servo.
    device: what the device measured.
    trace: of the device: time [s], mode, three positions [m], three forces [N].
    log: of the servo: time [us], then position [m] and force [N] of each tip.
    frames: of the session: time [s], stiffness cap then [N/m].
    model: what was pressed.
    load: the largest share of a tick that the model took in the servo's process.
    in_servo: the model ran in the servo's process.
    """

    cycles: int
    report: ServoReport
    device: dict[str, float]
    trace: Floats
    log: Floats
    frames: Floats
    model: Model
    load: float
    in_servo: bool


def add_haptics(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_haptics)
    command.add_argument("--emulate", action="store_true", required=True, help="with an emulated device")
    command.add_argument(
        "--seconds", type=float, default=10.0, metavar="N", help=f"of pressing, {SHORTEST:.2f} at least"
    )
    command.add_argument("--model", action="store_true", help="the model in the servo's process, not a local wall")
    command.add_argument("--cells", type=int, default=8, metavar="N", help="along an edge: 6 N^2 + 2 vertices")
    command.add_argument("--stiffness", type=float, metavar="K", help="of the cube [N/m], with no knee")
    command.add_argument("--loads", type=int, default=0, metavar="N", help="processes that keep processors busy")
    command.add_argument("--busy", action="store_true", help="stall the main thread for 200 ms each second")
    command.add_argument("--fault", action="append", default=[], metavar="FAULT", help="see `emulator --help`")
    command.add_argument("--baud", type=int, metavar="B", help="bits a second, 0: bytes take no time")
    command.add_argument("--udp", action="store_true", help="by UDP in place of a pseudo-terminal")
    command.add_argument("--json", type=Path, metavar="OUT", help="write the figures")


def run_haptics(options: argparse.Namespace) -> int:
    """Press, then print the figures."""
    words = [word for fault in options.fault for word in ("--fault", fault)]
    words += [] if options.baud is None else ["--baud", str(options.baud)]
    record = press(
        options.seconds, busy=options.busy, words=words, cells=options.cells, in_servo=options.model,
        loads=options.loads, udp=options.udp, stiffness=options.stiffness,
    )  # fmt: skip
    figures = judge(record)
    if record.report.arming is not Arming.ON:
        print(f"Not armed at the end, so forces and stiffness are too small. {record.report.note}")
    if not figures["real_time"]:
        print("This account has no real-time priority, so device and servo wait for other processes now and then.")
    print("\n".join(f"{name:<22} {value:.6g}" for name, value in figures.items()))
    if options.json:
        try:
            options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            raise DimpleError(f"{options.json} cannot be written: {error.strerror}.") from None
    return 0


def press(
    seconds: float, *, busy: bool = False, words: list[str] | None = None, cells: int = 8, in_servo: bool = False,
    loads: int = 0, udp: bool = False, stiffness: float | None = None,
) -> PressRecord:  # fmt: skip
    """Press a cube with three fingers for some seconds [s].

    Args:
        busy: the main thread stalls for STALL each second.
        words: more options of the emulator.
        cells: of the cube along an edge.
        in_servo: the model runs in the servo's process; else a local wall is rendered.
        loads: other processes that only compute.
        udp: the device is on the network of this computer.
        stiffness: of the cube [N/m], with no knee; else the preset's.

    Raises:
        DimpleError: the device does not connect or does not arm, or the time is too short for one press.
    """
    cycles = math.floor((seconds - READY_AFTER) / CYCLE + 1e-9)
    if cycles < 1:
        raise DimpleError(f"A press takes {SHORTEST:.2f} s: give --seconds at least that.")
    with tempfile.TemporaryDirectory(prefix="dimple-") as folder:
        trace, measured, log = (Path(folder) / name for name in ("trace.csv", "device.json", "log.csv"))
        device = InstrumentedDevice(
            hand=json.dumps({"tips": [_way(i, cycles) for i in range(3)]}),
            held_until=math.inf,
            udp=udp,
            emulator_words=["--trace", str(trace), "--json", str(measured), *(words or [])],
            servo_words=["--log", str(log)],
        )
        frames: list[tuple[float, float, float]] = []
        mesh, material = cube(cells, PRESET.size), PRESET.material
        if stiffness:
            material = replace(material, K1=stiffness, K2=stiffness)
        session = Session(build_model(mesh, [material], held=base_vertices(mesh)))
        others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(loads)]
        try:
            device.open()
            report = _drive(device, session, seconds, busy, frames, in_servo=in_servo)
        finally:
            device.close()
            for other in others:
                other.kill()
        if not (trace.exists() and measured.exists() and log.exists()):
            raise DimpleError("Device or servo did not end in time, so there is no trace: this computer is too busy.")
        rows = np.loadtxt(trace, delimiter=",", skiprows=1, ndmin=2)
        answers = np.loadtxt(log, delimiter=",", ndmin=2)
        return PressRecord(
            cycles, report, json.loads(measured.read_text()), rows, answers, np.array(frames)[:, :2], session.model,
            max(load for _, _, load in frames), in_servo,
        )  # fmt: skip


def judge(record: PressRecord) -> dict[str, float]:
    """Return the figures of a press, by the device's own trace."""
    device, report = record.device, record.report
    time, places, forces = record.trace[:, 0], _tips(record.trace, 2), _tips(record.trace, 11)
    begin = time[np.flatnonzero(record.trace[:, 1] == RAMP)[0]]
    law = record.model.materials[0].law
    holds = [_holding(record.cycles, time - begin, places[:, i], forces[:, i], law) for i in range(3)]
    slopes = np.array([slope for slope, _ in holds])
    errors = np.concatenate([error for _, error in holds])
    measured = record.log[:, 1:].reshape(-1, 3, 2, 3)[:, :, 0]
    row = np.searchsorted(time, record.log[:, 0] * 1e-6 - 1e-6)
    off = np.linalg.norm(measured - places[np.minimum(row, len(time) - 1)], axis=2)
    given = -np.cumsum((forces[:-1] * np.diff(places, axis=0)).sum(axis=2), axis=0)
    K1 = record.model.materials[0].K1
    static = static_errors(record, time - begin, begin, forces) if record.in_servo else np.zeros(1)
    return {
        "real_time": device["real_time"],
        "rate_hz": report.rate,
        "rtt_p50_us": device["rtt_p50_us"],
        "rtt_p99_us": device["rtt_p99_us"],
        "wire_us": device["wire_us"],
        "late_share": device["late_share"],
        "lost_frames": report.lost + device["lost"],
        "unsent_frames": report.unsent,
        "wrong_frames": int((off > WRONG).any(axis=1).sum()),
        "refused_frames": report.wrong + device["bad"],
        "force_rms_error_n": float(np.sqrt((errors**2).mean())),
        "force_largest_n": float(np.abs(forces).max()),
        "static_error": float(np.abs(static).max()),
        "static_rms_error": float(np.sqrt((static**2).mean())),
        "shake_mm": 1e3 * shake(record.cycles, time - begin, places),
        "model_load": record.load,
        "stiffness_error": float(np.abs(slopes / K1 - 1).max()),
        "stiffness_rendered_n_m": float(slopes.mean()),
        "stiffness_cap_n_m": float(np.median(record.frames[:, 1])),
        "longest_frame_ms": 1e3 * float(np.diff(record.frames[:, 0]).max()),
        "tip_rms_error_mm": 1e3 * float(np.sqrt((off**2).mean())),
        "energy_mj": 1e3 * float(given.min()),
        "observed_mj": 1e3 * min(tip.least_energy for tip in report.tips),
    }


def _tips(rows: Floats, first: int) -> Floats:
    return rows[:, first : first + 9].reshape(-1, 3, 3)


def _holding(
    cycles: int, time: Floats, places: Floats, forces: Floats, law: Callable[[float], float]
) -> tuple[float, Floats]:
    """Return the stiffness [N/m] from hold to hold, and the errors of the force against the law while holding [N]."""
    depths, pushes, errors = [], [], []
    for begin in _holds(cycles):
        during = (time > begin + SETTLE) & (time < begin + HOLD)
        if not during.any():
            break  # the device was lost
        depths.append(-np.median(places[during, 2]))
        pushes.append(np.median(forces[during, 2]))
        errors.append(forces[during, 2] - np.array([law(-z) for z in places[during, 2]]))
    if len(depths) < 2:
        raise DimpleError("The device was lost before it had pressed: this computer is too busy.")
    return float(np.polyfit(depths, pushes, 1)[0]), np.concatenate(errors)


def shake(cycles: int, time: Floats, places: Floats) -> float:
    """Return the farthest that a fingertip moves to and fro [m] in the later half of a hold, where it has settled."""
    spans = [0.0]
    for begin in _holds(cycles):
        during = (time > begin + HOLD / 2) & (time < begin + HOLD)
        spans.append(float(np.ptp(places[during], axis=0).max()) if during.any() else 0.0)
    return max(spans)


def static_errors(record: PressRecord, time: Floats, offset: float, forces: Floats) -> Floats:
    """Return by what share the force in each hold differs from that of a session with its fingertips there.

    Forces along the press; friction sideways depends on how a fingertip came.
    """
    session, errors = Session(record.model), []
    measured = record.log[:, 1:].reshape(-1, 3, 2, 3)[:, :, 0]
    for begin in _holds(record.cycles)[: len(LEVELS)]:
        during = (time > begin + SETTLE) & (time < begin + HOLD)
        seconds = record.log[:, 0] * 1e-6 - offset
        sensed = measured[(seconds > begin + SETTLE) & (seconds < begin + HOLD)].mean(axis=0)  # as the model was given
        for share in np.linspace(0.0, 1.0, 60):  # from above
            lifted = sensed + [0.0, 0.0, (1 - share) * CLEAR]
            session.set_fingers([Finger(WORKSPACE.to_session(tuple(tip)), RADIUS) for tip in lifted])
            session.step(0.005)
        session.step(0.5)
        wanted = session.step(0.05).finger_forces[:, 2]
        errors.append(forces[during, :, 2].mean(axis=0) / wanted - 1)
        session.reset()
    return np.array(errors)


def _holds(cycles: int) -> list[float]:
    """Return when the hand begins to hold [s]."""
    return [
        READY_AFTER + c * CYCLE + LIFT + i * (MOVE + HOLD) + MOVE for c in range(cycles) for i in range(len(LEVELS))
    ]


def _way(finger: int, cycles: int) -> list[Keyframe]:
    """Return the keyframes of a fingertip: above the top, then from level to level, and up again."""
    angle = finger * 2 * np.pi / 3
    x, y = float(-APART * np.cos(angle)), float(-APART * np.sin(angle))  # on the side of its block
    keys = [(READY_AFTER, x, y, CLEAR)]
    for c in range(cycles):
        at = READY_AFTER + c * CYCLE + LIFT
        keys += [(at, x, y, CLEAR)]
        for level in LEVELS:
            keys += [(at + MOVE, x, y, -level), (at + MOVE + HOLD, x, y, -level)]
            at += MOVE + HOLD
        keys += [(at + LIFT - 0.01, x, y, CLEAR)]
    return keys


def _drive(
    device: InstrumentedDevice, session: Session, seconds: float, busy: bool, frames: list[tuple[float, float, float]],
    *, in_servo: bool,
) -> ServoReport:  # fmt: skip
    """Step session and device together, as Blender does: 60 times a second."""
    rendering, armed, remote, parcels = ContactRendering(), 0.0, None, Parcels()
    if in_servo:
        remote = RemoteBody(session.body, session.model, parcels)
        remote.set_place(WORKSPACE, RADIUS)
    begun = last = stalled = time.perf_counter()
    while not armed or time.perf_counter() - armed < seconds:
        report = device.read()
        if report.link in (LinkState.REFUSED, LinkState.LOST) or (not armed and time.perf_counter() - begun > CONNECT):
            raise DimpleError(report.note or "The emulated device did not arm.")
        now = time.perf_counter()
        if report.link is LinkState.READY:
            if remote and session.body is not remote and report.body is BodyState.BUILT:
                remote.begin(session.model)
                session.body = remote
            session.set_fingers(fingers(report, WORKSPACE, RADIUS))
            session.step(min(now - last, 2 * FRAME))
            contacts = () if remote else rendering.contacts(session, WORKSPACE, report.cap, time.perf_counter())
            device.write(contacts, parcels.take(report))
            if report.body is BodyState.REFUSED:
                raise DimpleError(report.note)
            ready = not remote or report.body is BodyState.RUNS
            if report.arming is Arming.OFF and not armed and ready:
                device.arm()
            armed = armed or (now if report.arming in (Arming.RAMP, Arming.ON) else 0.0)
            frames.append((now, report.cap, report.load))
        last = now
        if busy and now - stalled > STALL_EVERY:
            stalled = now
            while time.perf_counter() - now < STALL:
                pass
        time.sleep(max(FRAME - (time.perf_counter() - now), 0.0))
    return report
