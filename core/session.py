"""A session: one body, its fingertips and its clock. Blender and the devices know only this.

Time runs in whole ticks of a millisecond whatever the frame rate, so the same press gives the same motion at
24 and at 120 frames a second; fingertips and held vertices move linearly from one call to the next.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .base import FINGER_TRAVEL, TICK, DimpleError, Floats
from .depth import depth_below, rest_surface
from .integrators import semi_implicit
from .laws import contact, pressure
from .laws.contact import Touch
from .laws.memory import Pose, fit_pose
from .model import Model, initial_state, law_force

MAX_FINGERS = 3


@dataclass(frozen=True, slots=True)
class Finger:
    """Hold a fingertip: the centre (3,) and radius of a sphere [m]."""

    position: tuple[float, float, float]
    radius: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Hold what a session shows after a step.

    time: [s].  positions: (N, 3) float32 [m].  finger_forces: (k, 3) on the fingertips, mean over the step [N].
    law_forces: (k,) K(x) of Eq. (1) [N] at depths: (k,) [m].  pressure: [Pa].  volume, rest_volume: [m3].
    substeps: per tick.  steps: ticks done.  cost: [s] of wall time.  note: "" or a sentence for the artist.
    """

    time: float
    positions: npt.NDArray[np.float32]
    finger_forces: Floats
    law_forces: Floats
    depths: Floats
    pressure: float
    volume: float
    rest_volume: float
    substeps: int
    steps: int
    cost: float
    finite: bool
    note: str


class Session:
    """Run one model."""

    def __init__(self, model: Model, *, tick: float = TICK) -> None:
        self.model = model
        self.tick = tick
        self.substeps = model.substeps(tick)
        self._surface = rest_surface(model.mesh)
        self._state = initial_state(model)
        first = np.zeros(len(model.mesh.rest_positions), np.int64)
        first[model.mesh.source[::-1]] = np.arange(len(model.mesh.source))[::-1]
        self._input_of = first
        self.reset()

    def reset(self) -> None:
        """Put the body back to rest and let go of it."""
        self._state = initial_state(self.model)
        self._held_pose: Pose = (np.eye(3), np.zeros(3))
        self._time, self._ticks = 0.0, 0
        self._fingers: list[Finger | None] = []
        self._targets: list[Finger | None] = []
        self._sides: list[Floats | None] = []
        self._held_target: Floats | None = None
        self.frame = self._show(np.zeros((0, 3)), 0, 0.0, "")

    def set_fingers(self, fingers: Sequence[Finger | None]) -> None:
        """Say where up to three fingertips are at the end of the next step; None lifts one off.

        Raises:
            DimpleError: too many fingertips, a radius that is not positive, or a position that is not a number.
        """
        if len(fingers) > MAX_FINGERS:
            raise DimpleError(f"There are at most {MAX_FINGERS} fingertips.")
        for finger in fingers:
            if finger and not (finger.radius > 0 and all(map(math.isfinite, (*finger.position, finger.radius)))):
                raise DimpleError("A fingertip needs a place that is a number and a radius greater than 0.")
        self._targets = list(fingers)
        for held in (self._fingers, self._sides):
            held.extend([None] * (len(fingers) - len(held)))
            del held[len(fingers) :]
        for i, finger in enumerate(fingers):
            if finger is None or self._fingers[i] is None:
                self._fingers[i], self._sides[i] = finger, None

    def set_held(self, positions: Floats) -> None:
        """Say where every input vertex (N, 3) [m] would be at the end of the next step if it were held."""
        self._held_target = np.asarray(positions, np.float64)[self._input_of].T

    def step(self, dt: float, *, budget: float | None = None) -> Frame:
        """Advance by dt [s] in whole ticks; what is left over is carried to the next call.

        Args:
            budget: stop after this much wall time [s]; the simulated time then lags behind.
        """
        started = time.perf_counter()
        end = self._time + dt
        due = math.floor(end / self.tick + 1e-6)
        impulses, done, note = np.zeros((len(self._targets), 3)), 0, ""
        while self._ticks < due:
            share = min(1.0, self.tick / max(end - self._ticks * self.tick, self.tick))
            impulses += self._advance(share)
            self._ticks, done = self._ticks + 1, done + 1
            if not self._is_finite():
                at = self._ticks * self.tick
                self.reset()
                note = f"The simulation blew up after {at:.3f} s and was put back to rest: soften the material."
                break
            if budget is not None and time.perf_counter() - started > budget and self._ticks < due:
                end = self._ticks * self.tick
                break
        if not note:
            self._time = end
        if done:
            forces = impulses / (done * self.tick)
        elif len(self.frame.finger_forces) == len(impulses):
            forces = self.frame.finger_forces
        else:
            forces = impulses
        self.frame = self._show(forces if not note else forces[:0], done, time.perf_counter() - started, note)
        return self.frame

    def _advance(self, share: float) -> Floats:
        """Run one tick, moving fingertips and held vertices their share of the way that is left."""
        state, model = self._state, self.model
        touches, which = [], []
        speed = float(np.sqrt((state.velocities**2).sum(axis=0).max(initial=0)))
        for i, (here, target) in enumerate(zip(self._fingers, self._targets, strict=True)):
            if here is None or target is None:
                continue
            start = np.array(here.position)
            way = share * (np.array(target.position) - start)
            way *= min(1.0, FINGER_TRAVEL * target.radius / max(float(np.linalg.norm(way)), 1e-30))
            end = start + way
            reach = target.radius + 2 * float(np.linalg.norm(way)) + 2 * speed * self.tick
            vertices, triangles = contact.candidates(
                state.positions, model.mesh.triangles, model.inverse_mass, end, reach
            )
            touches.append(
                Touch(
                    centre=end, velocity=way / self.tick, radius=target.radius, vertices=vertices, triangles=triangles
                )
            )
            which.append(i)
            self._fingers[i] = Finger(tuple(end), target.radius)
        self._move_held(share)
        if model.needs_contact:
            state.inner_force = float(sum(self._depths()[1]))
        total = np.zeros((len(self._targets), 3))
        for _ in range(self.substeps):
            total[which] += semi_implicit.step(model, state, touches, self.tick / self.substeps)
        return total

    def _move_held(self, share: float) -> None:
        held, state = self.model.held, self._state
        if self._held_target is None:
            return
        way = share * (self._held_target[:, held] - state.positions[:, held])
        state.velocities[:, held] = way / self.tick
        if state.pose is not None:
            pins = held & ~self.model.mesh.loose
            rest = self.model.memory.rest[:, pins]
            state.pose = fit_pose(rest, (state.positions[:, held] + way)[:, pins[held]], np.ones(rest.shape[1]))

    def _depths(self) -> tuple[list[float], list[float]]:
        """Return the depth [m] and the force [N] of Eq. (1) of each fingertip."""
        state, model = self._state, self.model
        weight = model.memory.k1 if model.memory.k1.any() else model.mass
        rotation, translation = state.pose or fit_pose(model.memory.rest, state.positions, weight)
        depths, law = [], []
        for i, finger in enumerate(self._fingers):
            if finger is None:
                depths.append(0.0)
                law.append(0.0)
                continue
            centre = rotation.T @ (np.array(finger.position) - translation)
            depth, triangle = depth_below(self._surface, centre, finger.radius, self._sides[i])
            if depth < finger.radius:  # its centre is still outside
                self._sides[i] = self._surface.normals[:, triangle] if depth > 0 else None
            depths.append(max(depth, 0.0))
            law.append(law_force(model, triangle, depth))
        return depths, law

    def _is_finite(self) -> bool:
        x = self._state.positions
        return bool(np.isfinite(x).all() and np.ptp(x, axis=1).max() < 100 * self.model.mesh.size)

    def _show(self, forces: Floats, steps: int, cost: float, note: str) -> Frame:
        state, model = self._state, self.model
        volume, _ = pressure.volume_and_gradient(model.pressure, state.positions)
        depths, law = self._depths()
        return Frame(
            time=self._time, positions=state.positions.T[model.mesh.source].astype(np.float32), finger_forces=forces,
            law_forces=np.array(law), depths=np.array(depths), pressure=state.pressure, volume=volume,
            rest_volume=model.mesh.volume, substeps=self.substeps, steps=steps, cost=cost, finite=not note, note=note,
        )  # fmt: skip
