"""A session: one body, its fingertips and its clock. Blender and the devices know only this.

Time runs in whole ticks of a millisecond whatever the frame rate, so the same press gives the same motion at
24 and at 120 frames a second; fingertips and pins move linearly from one call to the next.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ..base import TICK, DimpleError, Floats, Singles
from ..body.model import Model
from ..body.moved_rest import with_rest
from ..constants import MAX_STEPS
from ..message import Message
from ..native import create, motion
from ..native.motion import Motion
from ..other_tip import factors
from ..reduction.proxy import Proxy
from .clock import Clock
from .fingertip import Finger as Finger
from .fingertip import FingertipMotions, Fingertips
from .frame import Frame as Frame
from .rest_shape import Rest
from .skin import Pins, Skin
from .stepping import step_all

ANSWERED = 9  # ticks, those between two looks at a scene: after them a moving shape at rest answers what pushes it


class Session:
    """Run one model, or a proxy of it that carries its skin along.

    model: the model that is pressed.
    proxy: simulated in place of the model, None if the model itself is.
    body: the simulated body, which owns its state.
    backend: "native" (single precision) or "native64".
    contact_note: "" or what its self contact leaves out, for the artist.
    held_note: "" or which colliders were held back in the last step, for the artist.
    rest_shape: its shape at rest, which a rig bends and which sways.
    frame: result of the last step.
    most: largest number of ticks in one motion of the current step.
    clock: time of the session, which the fingertips follow.
    """

    def __init__(
        self, model: Model, *, tick: float = TICK, backend: str = "native", proxy: Proxy | None = None
    ) -> None:
        self.clock = Clock(tick)
        self.backend, self.contact_note, self.held_note = backend, "", ""
        self.substeps: int  # number in a tick
        self.body = create(self._define(model, Rest(model, proxy), proxy), surface=model, backend=backend)
        self.reset()

    def reset(self) -> None:
        """Put the body back to rest, in the shape of its model, and lift all fingertips."""
        if self.rest_shape.bent:  # rebuilt, so that the same motion gives the same bits again
            self.body = create(self._moves, surface=self.model, backend=self.backend)
        self.rest_shape.reset()
        self.body.set_state(self._moves.matching.rest)
        self._work, self._total = 0.0, 0
        self.clock.reset()
        self._tips = Fingertips()
        self._pins.rest_at(self.model.matching.rest)
        self._skin.reset()
        self._last = motion.Frame((), self.body.model.mesh.volume, 0.0, 0, True)
        self._done, self._note, self.most, self._started = 0, "", MAX_STEPS, time.perf_counter()
        self.frame = self._show()

    def set_fingers(self, fingers: Sequence[Finger | None]) -> None:
        """Set up to three fingertips for the end of the next step; None lifts one off.

        Raises:
            DimpleError: too many fingertips, a radius that is not positive, or a position that is not a number.
        """
        self._tips.send(fingers)
        if not self._tips.are_down:
            self.substeps = self._moves.substeps(self.clock.tick)

    def set_pins(self, positions: Floats) -> None:
        """Set the positions that the input vertices (N, 3) [m] would have at the end of the next step if pinned.

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        self._pins.target = self._skin.of_mesh(positions).T

    def set_rest(self, positions: Floats) -> None:
        """Set the shape at rest of the input vertices (N, 3) [m] at the end of the next step, as a rig bends it.

        If the model is rigged, these are also its positions in space; otherwise only the shape counts.

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        self.rest_shape.target = self._skin.of_mesh(positions).T

    def step(self, dt: float, *, budget: float | None = None) -> Frame:
        """Advance by dt [s] in whole ticks; the remainder is carried over to the next call.

        Args:
            budget: wall time [s] that only the first tick may exceed; simulated time then lags behind.

        Raises:
            DimpleError: dt is negative or not a number.
        """
        return step_all([self], [dt], budget=budget)[0]

    def begin(self, dt: float, *, alone: bool = True) -> None:
        """Begin a step of dt [s]; its ticks run in motions, and `finish` ends it.

        Args:
            alone: nothing but its fingertips can touch it.

        Raises:
            DimpleError: dt is negative or not a number.
        """
        self.clock.start(dt)
        meets = not alone or self._tips.are_down
        (self.rest_shape.let_go if meets else self.rest_shape.carry)(self.body)
        if alone:
            self.rest_shape.met = None
        self._done, self._note, self._started = 0, "", time.perf_counter()
        answers = meets and (self.rest_shape.sway or self.rest_shape.moves)
        self.most = ANSWERED if answers else MAX_STEPS // self.substeps - 1
        if self._tips.legs > 1:  # a path turns after each
            self.most = max(1, min(self.most, self.clock.due // self._tips.legs))

    @property
    def due(self) -> int:
        """Return the number of ticks left in the current step."""
        return 0 if self._note else self.clock.due

    def next_motion(self, ticks: int, *, substeps: int = 0) -> Motion:
        """Return the motion for some ticks of the current step.

        Args:
            substeps: number in each tick, 0 for as many as the model needs.
        """
        clock = self.clock
        pushes = self.rest_shape.pushes(self.fingers, self._last.touches)
        if ticks and (self.rest_shape.moves or pushes):
            self.rest_shape.bend(self.body, clock.share_of_remainder(ticks), ticks * clock.tick, pushes)
            if self.rides:
                self._skin.reset()
        if self.rides:
            return Motion(ticks, self.substeps, clock.tick, (None,) * len(self._tips))
        first = last = clock.share_after(ticks)
        if ticks > 1:
            first = max(clock.share_after(1), 0.0)  # the tick may begin before the step does
        pins = self._pins.lead(first, last)
        return Motion(ticks, substeps or self.substeps, clock.tick, self._motions(first, last), pins)

    def take(self, result: motion.Frame) -> bool:
        """Take the result of a motion; return whether the step continues."""
        self._last = result
        self.clock.ticks += result.ticks
        self._done += result.ticks
        self._total += result.ticks * self.substeps
        if result.moved:
            self._skin.reset()
        self._pins.take()
        self._work += self._tips.take(result.touches, result.ticks * self.clock.tick)
        if not result.finite:
            at, done = self.clock.ticks * self.clock.tick, self._done
            self.reset()
            note = Message(
                "The simulation diverged after {at:.3f} s and was reset. Lower k or K2, or raise the mass.",
                at=at,
            )
            self._done, self._note = done, note
        return result.finite

    def finish(self, *, early: bool = False) -> Frame:
        """End the current step, if early after the ticks done, and return its result."""
        if not self._note:
            if not self._done:  # evaluate fingertips that were put down or lifted
                self._last = self.body.step(Motion(0, self.substeps, self.clock.tick, self._motions(0.0, 0.0)))
            share = self.clock.stop(early=early)
            self._tips.move(share)
            if self._pins.move(share):
                self._skin.reset()
        self.frame = self._show()
        return self.frame

    @property
    def rides(self) -> bool:
        """Return whether the body sways untouched: it lies on its shape at rest, and is not stepped."""
        return self.rest_shape.carries

    @property
    def rest(self) -> Floats:
        """Return the shape at rest of the mesh (n, 3) [m], as its rig and its sway bend it."""
        return self.rest_shape.whole.T

    def bent_model(self) -> Model:
        """Return the simulated model with its current shape at rest."""
        return with_rest(self._moves, self.rest_shape.of_body) if self.rest_shape.bent else self._moves

    @property
    def moved(self) -> bool:
        """Return whether anything moved in the last step; False if the body slept throughout."""
        return self._last.moved or (self.rides and self.rest_shape.moves)

    @property
    def sway_hz(self) -> float:
        """Return the frequency of the body's slowest sway mode [Hz], 0 if it does not sway."""
        return self.rest_shape.sway.frequency if self.rest_shape.sway else 0.0

    def wake(self) -> None:
        """Let a sleeping body move again: what it rested on may be gone."""
        self.rest_shape.let_go(self.body)
        self.body.wake()

    @property
    def placed(self) -> tuple[Finger | None, ...]:
        """Return the fingertips at their current positions, those that a force pushes included."""
        return self._tips.placed

    @property
    def fingers(self) -> tuple[Finger | None, ...]:
        """Return the fingertips as they are to be at the end of the next step."""
        return self._tips.targets

    def law(self, index: int, depths: Sequence[float]) -> list[float]:
        """Return the forces [N] of the law that a fingertip which is down would get at depths [m] at its place."""
        finger = self.fingers[index]
        assert finger
        table = factors(self.model.materials, finger.radius, self.model.mesh.size)
        return self.body.law(index, np.asarray(depths), table).tolist()

    def positions(self) -> Singles:
        """Return the positions of the input vertices (N, 3) [m], read-only: the same array until something moves."""
        return self._skin.positions(self.body, self.placed)

    def change(self, model: Model, *, proxy: Proxy | None = None, scale: float = 1.0) -> None:
        """Continue with another model of the same vertices, from the present state: nothing moves at the change.

        A vertex that the new model pins stays in place until the pins are moved.

        Args:
            proxy: simulated in place of the new model, None if that itself is.
            scale: factor by which all lengths of the new model are larger.

        Raises:
            DimpleError: it cannot be simulated, or has other vertices; the session continues unchanged.
        """
        moves, before, surface = proxy.model if proxy else model, self.body.model, self.model
        moves.substeps(self.clock.tick)
        if len(model.matching.rest.T) != len(surface.matching.rest.T):
            raise DimpleError("The vertices of the mesh have changed since the start. Reset it and start again.")
        self.rest_shape.let_go(self.body)
        skin = scale * np.asarray(self._skin.surface(self.body), np.float64)
        led = self._pins.target
        if model.mesh is surface.mesh and moves.mesh is before.mesh:
            self.body.set_constants(moves, surface=model)
        else:
            at, speed = skin, scale * self._skin.velocities(self.body)
            if proxy:
                at, speed = at[proxy.seeds], speed[proxy.seeds]
            self.body = create(moves, surface=model, backend=self.backend)
            self.body.set_state(at.T, speed.T)
            self._tips.scale(scale)
            led = None
        self._define(model, Rest(model, proxy, self.rest_shape), proxy)
        if self.rest_shape.bent and moves.mesh is not before.mesh:
            self.rest_shape.lay(self.body)
        self._pins.origin, self._pins.target = skin.T, led

    def _define(self, model: Model, rest: Rest, proxy: Proxy | None) -> Model:
        """Set what follows from a model, its shape at rest and its proxy; return the simulated model."""
        moves = proxy.model if proxy else model
        self.substeps = moves.substeps(self.clock.tick)
        self.model, self.proxy, self._moves = model, proxy, moves
        self._volume_scale = model.mesh.volume / moves.mesh.volume if moves.mesh.volume > 0 else 1.0
        self.rest_shape = rest
        self._pins: Pins = Pins(model, proxy)
        self._skin: Skin = Skin(model, proxy, self._pins, rest)
        return moves

    def _motions(self, first: float, last: float) -> FingertipMotions:
        """Return the motion of each fingertip for some ticks."""
        return self._tips.motions(first, last, self.model.materials, self.model.mesh.size)

    def skin(self) -> Floats:
        """Return the positions of the vertices (n, 3) [m] of the mesh."""
        return np.asarray(self._skin.on(self.placed, self._skin.surface(self.body)), np.float64)

    def _show(self) -> Frame:
        last, scale, rest = self._last, self._volume_scale, self.model.mesh.volume
        if self.rest_shape.bent and not self.rides:  # the call takes time
            rest = self.body.rest_volume * scale
        return Frame(
            self.clock.time, last.touches, self.model.mesh, last.pressure, last.volume * scale, rest,
            self.substeps, self._done, time.perf_counter() - self._started, self._total, self._work, self._note,
        )  # fmt: skip
