"""The model beside the servo on one injected clock: emulated device, servo and body, without processes."""

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from core.body.model import Model, build_model
from core.haptics.body_host import BodyHost
from core.haptics.contact_rendering import Workspace
from core.haptics.emulated_hand import EmulatedHand, Keyframe
from core.haptics.parcel import Change, frame_size, pack_changes, parcel_path
from core.haptics.safety import LEASE
from core.haptics.servo import Servo
from core.haptics.servo_messages import LinkState, Order
from core.haptics.spec import Spec, load_spec
from core.haptics.wire import RAMP
from core.material import PRESETS, Material
from core.mesh.surface import base_vertices
from studies.faulty_emulator import FaultyEmulator, TraceRow
from studies.scenes import cube

STEP = 2e-4  # [s] of the clock
RADIUS = 0.010  # [m]
SIZE = PRESETS[1].size
WORKSPACE = Workspace(origin=(0.0, 0.0, SIZE / 2 + RADIUS))
BEGIN = 1.2  # [s] after the device's ramp
SIDES = ((-0.04, 0.0), (0.02, 0.035), (0.02, -0.035))  # [m] of the fingertips on the top


def soft_cube(material: Material | None = None, cells: int = 8) -> Model:
    """Return a cube on its base, as large as Object 2."""
    mesh = cube(cells, SIZE)
    return build_model(mesh, [material or PRESETS[1].material], pinned=base_vertices(mesh))


def pressing(*depths: float, hold: float = 0.4, stiffness: float | None = 400.0, damping: float = 4.0) -> EmulatedHand:
    """Return a hand that wants its fingertips at depths [m] below the top, one after the other."""
    tips: list[tuple[Keyframe, ...]] = []
    for x, y in SIDES:
        time, keys = BEGIN, [(BEGIN, x, y, 0.01)]
        for depth in depths:
            keys += [(time + 0.15, x, y, -depth), (time + 0.15 + hold, x, y, -depth)]
            time += 0.15 + hold
        tips.append(tuple(keys))
    return EmulatedHand(tips=tuple(tips), stiffness=stiffness, damping=damping)


@dataclass
class ModelRig:
    """A device with a body beside its servo.

    stuck: for a time [s] the share of ticks at which the servo's process does not run for `stall` [s].
    baud: bits a second of the line, None: the device's, 0: bytes take no time.
    deaf_until: the line holds the device's bytes back until then [s].
    """

    model: Model
    hand: EmulatedHand
    spec: Spec = field(default_factory=load_spec)
    workspace: Workspace = WORKSPACE
    stuck: float = 0.0
    stall: float = 0.0025
    seed: int = 0
    baud: int | None = None

    def __post_init__(self) -> None:
        self.ticks: list[TraceRow] = []
        self.emulator = FaultyEmulator(self.spec, hand=self.hand, trace=self.ticks, baud=self.baud)
        self.servo = Servo(self.spec)
        self._folder = tempfile.TemporaryDirectory(prefix="dimple-")
        self._box = Path(self._folder.name) / "box"
        self.host = BodyHost(self._box)
        self.now, self._data, self._late, self._sleeps, self.deaf_until = 0.0, b"", b"", 0.0, 0.0
        self._dice = np.random.default_rng(self.seed)
        self.order, self.rows, self.begun = Order(), [], math.inf
        rest = self.model.matching.rest
        self.pinned = True
        frames = Path(self._folder.name) / "frames"
        frames.write_bytes(bytes(frame_size(rest.shape[1]) + 8))
        self.send(
            ("body", self.model, self.model, str(frames)),
            ("place", self.workspace.origin, self.workspace.scale, self.workspace.turn, RADIUS),
            ("state", rest, None),
        )
        self.run(0.1)
        self.order = replace(self.order, arm=1)

    def send(self, *changes: Change) -> None:
        """Give the servo's process changes of its body."""
        self.order = replace(self.order, parcel=self.order.parcel + 1)
        parcel_path(self._box, self.order.parcel).write_bytes(pack_changes(changes))

    def run(self, seconds: float, each: Callable[[], None] | None = None) -> None:
        """Let time pass."""
        until = self.now + seconds
        while self.now < until:
            self.now += STEP
            out = self.emulator.step(self.now, self._data)
            self._data = b""
            if self.now < self._sleeps:
                self._late += out
                continue
            if self.now < self.deaf_until:
                self._late, out = self._late + out, b""
            else:
                out, self._late = self._late + out, b""
            if self.pinned:
                self.order = replace(self.order, held_until=self.now + LEASE, written=self.now)
            self.servo.order = self.host.order(self.order, self.servo, self.now)
            before = self.servo.answered
            self._data = self.servo.step(self.now, out)
            self.host.advance(self.servo, self.now)
            if self.servo.answered == before:
                continue
            if self._dice.random() < self.stuck:
                self._sleeps = self.now + self.stall
            if self.begun == math.inf and self.emulator.mode == RAMP:
                self.begun = self.now
            if self.begun < math.inf:
                body = self.host.touched
                forces = body.forces if body else [(0.0, 0.0, 0.0)] * 3
                tips = [tip.position for tip in self.emulator.tips]
                sensed = [place or (math.nan,) * 3 for place in self.servo.places]
                self.rows.append((self.now - self.begun, tips, list(self.emulator.forces), list(forces), sensed))
            if each:
                each()

    def trace(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return times (t,) [s], positions (t, 3, 3) [m], forces of the motors and of the model (t, 3, 3) [N]."""
        time, *rest = zip(*self.rows, strict=True)
        positions, forces, model, _ = (np.array(each) for each in rest)
        return np.array(time), positions, forces, model

    def sensed(self) -> np.ndarray:
        """Return the positions (t, 3, 3) [m] by the device's converters, which are 0.25 mm a step."""
        return np.array([row[4] for row in self.rows])

    def energy(self) -> float:
        """Return the lowest energy [J] that a hand had given a motor, by each tick of the device."""
        rows = np.array(self.ticks)
        x, force = rows[:, 2:11].reshape(-1, 3, 3), rows[:, 11:].reshape(-1, 3, 3)
        return float(-np.cumsum((force[:-1] * np.diff(x, axis=0)).sum(axis=2), axis=0).max())

    def observed(self) -> float:
        """Return the lowest energy [J] that the servo observed."""
        return min(tip.least_energy for tip in self.servo.report().tips)


def holding(time: np.ndarray, number: int, hold: float = 0.4) -> np.ndarray:
    """Tell which times are in the second half of a hold."""
    end = BEGIN + (number + 1) * (0.15 + hold)
    return (time > end - hold / 2) & (time < end - 0.01)


def ready(rig: ModelRig) -> bool:
    return rig.servo.link is LinkState.READY


def materials(*stiffness: float) -> Sequence[Material]:
    return [replace(PRESETS[1].material, K1=k, K2=k) for k in stiffness]
