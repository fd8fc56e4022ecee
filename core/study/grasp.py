"""Three fingertips of an emulated device lift a cube by friction alone and put it down: all in one process, on one
clock that is handed on, so that it runs the same everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..base import STANDARD_GRAVITY
from ..devices.emulator import Emulator
from ..devices.felt import Felt, Workspace, fingers
from ..devices.hand import Hand, Keyframe
from ..devices.letters import Link, Report
from ..devices.safety import Arming
from ..devices.servo import Servo
from ..devices.spec import Spec, load_spec
from ..devices.vectors import Vector
from ..material import PRESETS
from ..model import build_model
from ..session import Frame, Session
from .scenes import cube

PRESET = PRESETS[0]  # nylon and air: a light cube of 50 mm
RADIUS = 0.010  # [m] of the fingertips
LIFT = 0.060  # [m]
CLEAR = 0.010  # [m] beside the cube
SQUEEZE = 0.012  # [m] where the hand wants its fingertips inside; they yield to the force
BESIDE = 0.2  # of the edge: of index and middle finger from the middle
# [s] from the device's ramp: begin, touched, squeezed, lifted, lowered from, on the ground, let go
TOUCH, SQUEEZED, RAISE, RAISED, LOWER, DOWN, OPEN, END = 1.3, 1.6, 1.8, 2.4, 3.0, 3.6, 3.9, 4.2
STEP = 2e-4  # [s] of the clock: a host that answers within it
FRAME = 1 / 60  # [s]


@dataclass(frozen=True, slots=True)
class Moment:
    """Hold a frame: its time since the hand began [s], what the session shows, what the servo says, the height of the
    cube [m] and the true forces of the motors [N]."""

    time: float
    frame: Frame
    report: Report
    height: float
    forces: list[Vector]


def grasp(cells: int = 3, *, friction: float = PRESET.material.friction) -> Session:
    """Return the cube, free on the ground, centred on the origin."""
    material = replace(PRESET.material, friction=friction)
    mesh, down = cube(cells, PRESET.size), (0, 0, -STANDARD_GRAVITY)
    return Session(build_model(mesh, [material], gravity=down, ground=-PRESET.size / 2))


def hand() -> Hand:
    """Return the hand: thumb on one side, index and middle finger on the other, where their blocks are."""
    edge = PRESET.size
    beside = ((-1.0, 0.0), (1.0, -BESIDE * edge), (1.0, BESIDE * edge))
    return Hand(tips=tuple(_way(side, y) for side, y in beside))


def _way(side: float, y: float) -> tuple[Keyframe, ...]:
    touch = PRESET.size / 2 + RADIUS
    out, grip = side * (touch + CLEAR), side * (touch - SQUEEZE)
    way = ((TOUCH, out, 0.0), (SQUEEZED, grip, 0.0), (RAISE, grip, 0.0), (RAISED, grip, LIFT), (LOWER, grip, LIFT),
           (DOWN, grip, 0.0), (OPEN, out, 0.0))  # fmt: skip
    return tuple((time, x, y, z) for time, x, z in way)


def run(session: Session, *, spec: Spec | None = None, seconds: float = END) -> Iterator[Moment]:
    """Let the hand grasp; yield each frame once there is force."""
    spec = spec or load_spec()
    emulator, servo = Emulator(spec, hand=hand()), Servo(spec)
    felt, place = Felt(), Workspace()
    now, next_frame, began, to_device = 0.0, 0.0, None, b""
    while began is None or now - began < seconds:
        now += STEP
        to_device = servo.step(now, emulator.step(now, to_device))
        if now < next_frame or servo.link is not Link.READY:
            continue
        next_frame = now + FRAME
        report = servo.report()
        session.set_fingers(fingers(report, place, RADIUS))
        frame = session.step(FRAME)
        servo.order = replace(servo.order, arm=1, contacts=felt.contacts(session, place, report.cap, now))
        if began is None and report.arming is Arming.RAMP:
            began = now
        if began is not None:
            yield Moment(now - began, frame, report, _height(frame), list(emulator.forces))


def _height(frame: Frame) -> float:
    return float(frame.positions[:, 2].mean())
