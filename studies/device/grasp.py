"""`dev.py core grasp`: three fingertips of an emulated device lift a cube by friction alone and put it down.

All in one process, on one injected clock, so that it runs the same everywhere.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.body.model import build_model
from core.device.force_guard import Arming
from core.device.limits import LEASE
from core.device.orders import LinkState, ServoReport
from core.device.servo import Servo
from core.device.workspace import Workspace, fingers, surfaces_of
from core.session import Session
from core.vectors import Vector
from studies.bench.emulator import Emulator
from studies.bench.hand import EmulatedHand, Keyframe
from studies.bench.numbers import EmulatedSpec, load_emulated
from studies.files import write_json
from studies.paper_objects import PRESETS
from studies.scenes import cube

PRESET = PRESETS[0]  # nylon and air: a light cube of 50 mm
RADIUS = 0.010  # [m] of the fingertips
LIFT = 0.060  # [m]
CLEAR = 0.010  # [m] beside the cube
SQUEEZE = 0.012  # [m] where the hand wants its fingertips inside; they yield to the force
BESIDE = 0.2  # share of the edge by which index and middle finger are off the middle
# [s] from the device's ramp: begin, touched, squeezed, lifted, lowered from, on the ground, let go
TOUCH, SQUEEZED, RAISE, RAISED, LOWER, DOWN, OPEN, END = 1.3, 1.6, 1.8, 2.4, 4.4, 5.0, 5.3, 5.6
MOMENTS = {"open": TOUCH, "squeezed": RAISE, "lifted": RAISED + 0.1, "held": LOWER, "put down": DOWN, "let go": END}
STEP = 2e-4  # [s] of the clock: a host that answers within it
FRAME = 1 / 60  # [s]
GRAVITY = 9.81  # [m/s2]


@dataclass(frozen=True, slots=True)
class Moment:
    """A frame of the grasp.

    time: since the hand began [s].
    borne: forces of the body on the fingertips [N].
    report: of the servo.
    height: of the cube's middle [m].
    size: of its longest side [m].
    forces: true forces of the motors [N].
    """

    time: float
    borne: list[Vector]
    report: ServoReport
    height: float
    size: float
    forces: list[Vector]


def grasp(cells: int = 3, *, friction: float = PRESET.material.friction) -> Session:
    """Return the cube, free on the ground, centred on the origin."""
    material = replace(PRESET.material, friction=friction)
    mesh, down = cube(cells, PRESET.size), (0, 0, -GRAVITY)
    return Session(build_model(mesh, [material], gravity=down, ground=-PRESET.size / 2))


def hand() -> EmulatedHand:
    """Return the hand: thumb on one side, index and middle finger on the other, as their blocks are."""
    edge = PRESET.size
    beside = ((-1.0, 0.0), (1.0, -BESIDE * edge), (1.0, BESIDE * edge))
    return EmulatedHand(tips=tuple(_way(side, y) for side, y in beside))


def _way(side: float, y: float) -> tuple[Keyframe, ...]:
    touch = PRESET.size / 2 + RADIUS
    out, grip = side * (touch + CLEAR), side * (touch - SQUEEZE)
    way = ((TOUCH, out, 0.0), (SQUEEZED, grip, 0.0), (RAISE, grip, 0.0), (RAISED, grip, LIFT), (LOWER, grip, LIFT),
           (DOWN, grip, 0.0), (OPEN, out, 0.0))  # fmt: skip
    return tuple((time, x, y, z) for time, x, z in way)


def run(session: Session, *, spec: EmulatedSpec | None = None, seconds: float = END) -> Iterator[Moment]:
    """Grasp; yield each frame once there is force."""
    spec = spec or load_emulated()
    emulator, servo = Emulator(spec, hand=hand()), Servo()
    workspace = Workspace()
    now, next_frame, began, to_device = 0.0, 0.0, None, b""
    while began is None or now - began < seconds:
        now += STEP
        to_device = servo.step(now, emulator.step(now, to_device))
        if now < next_frame or servo.link is not LinkState.READY:
            continue
        next_frame = now + FRAME
        report = servo.report()
        session.set_fingers(fingers(report, workspace, RADIUS))
        frame = session.step(FRAME)
        surfaces = tuple(surfaces_of(session, frame.touches, workspace, now))
        servo.order = replace(servo.order, arm=1, held_until=now + LEASE, surfaces=surfaces)
        if began is None and report.arming is Arming.RAMP:
            began = now
        if began is not None:
            x, borne = session.positions(), [*map(tuple, frame.finger_forces)]
            size = float(np.ptp(x, axis=0).max())
            yield Moment(now - began, borne, report, float(x[:, 2].mean()), size, list(emulator.forces))


def add_grasp(command: argparse.ArgumentParser) -> None:
    """Give the command its options."""
    command.set_defaults(run=run_grasp)
    command.add_argument("--cells", type=int, default=3, help="cells along an edge of the cube")
    command.add_argument("--json", type=Path, metavar="OUT", help="write height and forces of each frame")


def run_grasp(options: argparse.Namespace) -> int:
    """Grasp, then print how high the cube was and the forces on the fingertips."""
    session = grasp(options.cells)
    moments, weight = list(run(session)), GRAVITY * float(session.model.mass.sum())
    print("when        time   cube up   thumb          index          middle: force inward, force down")
    for name, time in MOMENTS.items():
        moment = min(moments, key=lambda moment: abs(moment.time - time))
        forces = "   ".join(f"{abs(force[0]):5.2f} {-force[2]:5.2f} N" for force in moment.forces)
        print(f"{name:<9} {moment.time:5.2f} s  {1e3 * moment.height:5.1f} mm  {forces}")
    held = [moment for moment in moments if MOMENTS["lifted"] <= moment.time <= LOWER]
    borne = -float(np.mean([sum(force[2] for force in moment.forces) for moment in held]))
    report = moments[-1].report
    print(f"The cube weighs {weight:.2f} N. Lifted, it pulls the fingertips down by {borne:.2f} N.")
    least = [min(abs(m.forces[i][0]) for m in moments if RAISE <= m.time <= DOWN) for i in range(3)]
    print(f"From the lift until it is down, no fingertip feels less than {min(least):.2f} N.")
    print(f"Device {report.arming.name.lower()}, frames lost {report.lost}.")
    if options.json:
        rows = [{"time_s": m.time, "height_m": m.height, "forces_n": m.forces} for m in moments]
        write_json(options.json, rows)
    return 0
