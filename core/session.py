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
from .body import pressure
from .body.model import Model, initial_state
from .body.shape_matching import Pose, carried_pose, fit_pose
from .mesh.depth import Touching, rest_surface, touching
from .mesh.surface import input_vertices
from .reduction.proxy import Proxy, carry, contact_radius
from .solver.backend import choose_backend
from .solver.path import FingerPath

MAX_FINGERS = 3
TICKS_AT_ONCE = 8  # between looks at the clock and at whether the body is still whole


@dataclass(frozen=True, slots=True)
class Finger:
    """Hold a fingertip: the centre (3,) and radius of a sphere [m]."""

    position: tuple[float, float, float]
    radius: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Hold what a session shows after a step.

    time: [s].  positions: (N, 3) float32 [m].  finger_forces: (k, 3) on the fingertips, mean over the step [N].
    law_forces: (k,) K(x) of Eq. (1) [N] at depths: (k,) [m].  materials: (k,) which of the model's it is nearest to,
    -1 where none is down.  touches: how each meets the surface at rest, which a device lets feel.  pressure: [Pa].
    volume, rest_volume: [m3].  substeps: per tick.  steps: ticks done.  cost: [s] of wall time.  total_steps,
    total_cost: substeps and [s] since the start.  note: "" or a sentence.
    """

    time: float
    positions: npt.NDArray[np.float32]
    finger_forces: Floats
    law_forces: Floats
    depths: Floats
    materials: tuple[int, ...]
    touches: tuple[Touching | None, ...]
    pressure: float
    volume: float
    rest_volume: float
    substeps: int
    steps: int
    cost: float
    total_steps: int
    total_cost: float
    finite: bool
    note: str


class Session:
    """Run one model, or a stand-in for it that carries its skin along.

    backend: "native" (single precision), "native64" or "numpy".  backend_note: "" or why it is numpy, for the artist.
    """

    def __init__(self, model: Model, *, tick: float = TICK, backend: str = "auto", proxy: Proxy | None = None) -> None:
        if not tick > 0:
            raise DimpleError(f"A tick must be longer than 0 s (it is {tick}).")
        self.model, self.proxy = model, proxy
        self._body = proxy.model if proxy else model  # what moves
        self.tick = tick
        self.substeps = self._body.substeps(tick)
        self.backend, self.backend_note, self._stepper = choose_backend(backend)
        self._whole = not self._body.mesh.loose.any()
        self._surface = rest_surface(model.mesh)
        self._input_of = input_vertices(model.mesh)
        # the vertices of the mesh that are told where to be
        self._pinned = np.flatnonzero(model.held) if proxy is None else proxy.seeds[self._body.held]
        self._followed = self._pinned if proxy is None else np.union1d(self._pinned, np.flatnonzero(proxy.still))
        self.reset()

    def reset(self) -> None:
        """Put the body back to rest and let go of it."""
        self._state = initial_state(self._body)
        self._time, self._ticks, self._cost = 0.0, 0, 0.0
        self._fingers: list[Finger | None] = []
        self._targets: list[Finger | None] = []
        self._sides: list[Floats | None] = []
        self._begin, self._end = 0.0, 0.0  # of the step under way, and where fingertips and pins were at its begin:
        self._origins: list[Floats | None] = []
        self._held_origin: Floats = self.model.matching.rest  # of the mesh, not of a stand-in
        self._held_target: Floats | None = None
        self.frame = self._show(np.zeros((0, 3)), 0, 0.0, "")

    def place(self, positions: Floats) -> None:
        """Put the vertices (3, n) [m] of what moves somewhere else, at rest: the start of a study."""
        self._state.positions[:] = positions

    def set_fingers(self, fingers: Sequence[Finger | None]) -> None:
        """Say where up to three fingertips are at the end of the next step; None lifts one off.

        Raises:
            DimpleError: too many fingertips, a radius that is not positive, or a position that is not a number.
        """
        if len(fingers) > MAX_FINGERS:
            raise DimpleError(f"There are at most {MAX_FINGERS} fingertips.")
        for finger in fingers:
            if finger and not (
                finger.radius > 0
                and len(finger.position) == 3
                and all(map(math.isfinite, (*finger.position, finger.radius)))
            ):
                raise DimpleError("A fingertip needs a place that is a number and a radius greater than 0.")
        self._targets = list(fingers)
        for held in (self._fingers, self._sides, self._origins):
            held.extend([None] * (len(fingers) - len(held)))
            del held[len(fingers) :]
        for i, finger in enumerate(fingers):
            if finger is None or self._fingers[i] is None:
                self._fingers[i], self._sides[i] = finger, None
                self._origins[i] = np.array(finger.position) if finger else None

    def set_held(self, positions: Floats) -> None:
        """Say where every input vertex (N, 3) [m] would be at the end of the next step if it were held.

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        positions = np.asarray(positions, np.float64)
        if positions.shape != (len(self.model.mesh.source), 3):
            raise DimpleError(f"The mesh has {len(self.model.mesh.source)} vertices: give a position for each.")
        if not np.isfinite(positions[self._input_of][self._followed]).all():
            raise DimpleError("A held vertex has a position that is not a number.")
        self._held_target = positions[self._input_of].T

    def step(self, dt: float, *, budget: float | None = None) -> Frame:
        """Advance by dt [s] in whole ticks; what is left over is carried to the next call.

        Args:
            budget: stop after this much wall time [s]; the simulated time then lags behind.

        Raises:
            DimpleError: dt is negative or not a number.
        """
        if not 0 <= dt < math.inf:
            raise DimpleError(f"A step of time must be 0 s or longer (it is {dt}).")
        started = time.perf_counter()
        self._begin, self._end = self._time, self._time + dt
        end, due = self._end, math.floor(self._end / self.tick + 1e-6)
        impulses, done, note = np.zeros((len(self._targets), 3)), 0, ""
        while self._ticks < due:
            ticks = self._ticks_at_once(due - self._ticks)
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # a blow-up has its own note
                impulses += self._run(ticks)
            self._ticks, done = self._ticks + ticks, done + ticks
            if not self._is_finite():
                at = self._ticks * self.tick
                self.reset()
                note = f"The simulation blew up after {at:.3f} s and was put back to rest: soften the material."
                break
            if budget is not None and time.perf_counter() - started > budget and self._ticks < due:
                end = self._ticks * self.tick
                break
        if not note:
            self._move_origins(self._share(end))
            self._time = end
        was = self.frame.finger_forces
        forces = impulses / (done * self.tick) if done else was if len(was) == len(impulses) else impulses
        self.frame = self._show(forces if not note else forces[:0], done, time.perf_counter() - started, note)
        return self.frame

    def _ticks_at_once(self, due: int) -> int:
        """Return how many ticks one call of the stepper may run: one where something must be looked at each tick."""
        return 1 if self._body.needs_contact or self._held_target is not None else min(due, TICKS_AT_ONCE)

    def _share(self, time: float) -> float:
        """Return how much of the step under way is over at a time [s]: 0 at its begin, 1 at its end."""
        return min((time - self._begin) / max(self._end - self._begin, 1e-30), 1.0)

    def _move_origins(self, share: float) -> None:
        for i, (origin, target) in enumerate(zip(self._origins, self._targets, strict=True)):
            if origin is not None and target:
                self._origins[i] = origin + share * (np.array(target.position) - origin)
        if self._held_target is not None:
            self._held_origin = self._held_origin + share * (self._held_target - self._held_origin)

    def _run(self, ticks: int) -> Floats:
        """Run some ticks.

        Returns:
            the impulse (k, 3) [N s] on each fingertip.
        """
        which = [i for i, (f, t) in enumerate(zip(self._fingers, self._targets, strict=True)) if f and t]
        path = FingerPath(
            centres=np.array([self._way(i, ticks) for i in which]).reshape(len(which), ticks + 1, 3),
            radii=np.array([self._radius(i) for i in which]),
        )
        self._move_held(self._share((self._ticks + 1) * self.tick))
        if self._body.needs_contact:
            self._state.inner_force = float(sum(force for _, force, _ in map(self._law, self._touches())))
        total = np.zeros((len(self._targets), 3))
        total[which] = self._stepper(self._body, self._state, path, tick=self.tick, substeps=self.substeps)
        for row, i in enumerate(which):
            self._fingers[i] = Finger(tuple(path.centres[row, -1]), self._targets[i].radius)  # type: ignore[union-attr]
        return total

    def _radius(self, i: int) -> float:
        """Return the radius [m] with which a fingertip meets what moves."""
        target = self._targets[i]
        assert target
        return contact_radius(self.proxy, target.radius) if self.proxy else target.radius

    def _way(self, i: int, ticks: int) -> Floats:
        """Return the centres (ticks + 1, 3) of a fingertip, no faster than it may move without skipping a skin."""
        here, target, origin = self._fingers[i], self._targets[i], self._origins[i]
        assert here and target and origin is not None
        most, centres = FINGER_TRAVEL * target.radius, [np.array(here.position)]
        for tick in range(self._ticks + 1, self._ticks + ticks + 1):
            step = origin + self._share(tick * self.tick) * (np.array(target.position) - origin) - centres[-1]
            centres.append(centres[-1] + step * min(1.0, most / max(math.hypot(*step), 1e-30)))
        return np.array(centres)

    def _move_held(self, share: float) -> None:
        held, state = self._body.held, self._state
        if self._held_target is None:
            return
        origin = self._held_origin[:, self._pinned]
        way = origin + share * (self._held_target[:, self._pinned] - origin) - state.positions[:, held]
        state.velocities[:, held] = way / self.tick
        if state.pose is not None:
            pins = held & ~self._body.mesh.loose
            rest, here = self._body.matching.rest[:, pins], state.positions[:, pins]
            there = here + way[:, pins[held]]
            state.pose, state.pace = carried_pose(rest, here, there, tick=self.tick, substeps=self.substeps)

    def _pose(self) -> Pose:
        """Return where the shape at rest is now."""
        body = self._body
        weight = body.matching.k1 if body.matching.k1.any() else body.mass
        return self._state.pose or fit_pose(body.matching.rest, self._state.positions, weight)

    def _touches(self) -> list[Touching | None]:
        """Return how each fingertip meets the surface at rest, and remember by which side it came in."""
        pose, touches = self._pose(), list[Touching | None]()
        for i, finger in enumerate(self._fingers):
            side = self._sides[i]
            touch = touching(self._surface, pose, np.array(finger.position), finger.radius, side) if finger else None
            if touch and finger and touch.depth < finger.radius:  # its centre is still outside
                self._sides[i] = self._surface.normals[:, touch.triangle] if touch.depth > 0 else None
            touches.append(touch)
        return touches

    def _law(self, touch: Touching | None) -> tuple[float, float, int]:
        """Return a fingertip's depth [m], its force [N] by Eq. (1), and which material it is nearest to."""
        if touch is None:
            return 0.0, 0.0, -1
        material = int(self.model.mesh.triangle_material[touch.triangle])
        return max(touch.depth, 0.0), self.model.materials[material].law(touch.depth), material

    def _is_finite(self) -> bool:
        x = self._state.positions if self._whole else self._state.positions[:, ~self._body.mesh.loose]
        return bool(np.isfinite(x).all() and np.ptp(x, axis=1).max() < 100 * self.model.mesh.size)

    def _skin(self) -> Floats:
        """Return where the vertices (n, 3) [m] of the mesh are."""
        if self.proxy is None:
            return self._state.positions.T
        x, still = carry(self.proxy, self._state.positions), self.proxy.still
        x[still] = self._held_origin.T[still]
        return x

    def _show(self, forces: Floats, steps: int, cost: float, note: str) -> Frame:
        state, model = self._state, self.model
        self._cost += cost
        volume, _ = pressure.volume_and_gradient(self._body.pressure, state.positions)
        if self._body.mesh.volume > 0:
            volume *= model.mesh.volume / self._body.mesh.volume
        touches = self._touches()
        depths, law, materials = zip(*map(self._law, touches), strict=True) if touches else ((), (), ())
        return Frame(
            time=self._time, positions=self._skin()[model.mesh.source].astype(np.float32), finger_forces=forces,
            law_forces=np.array(law), depths=np.array(depths), materials=materials, touches=tuple(touches),
            pressure=state.pressure, volume=volume, rest_volume=model.mesh.volume, substeps=self.substeps, steps=steps,
            cost=cost, total_steps=self._ticks * self.substeps, total_cost=self._cost, finite=not note, note=note,
        )  # fmt: skip
