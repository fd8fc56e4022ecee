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
from ..constants import MAX_FINGERTIPS, MAX_STEPS
from ..messages import Message
from ..native import Body, create, motion
from ..native.motion import Motion
from ..other_tip import factors
from ..reduction.proxy import Proxy
from ..vectors import ZERO, Vector
from .clock import Clock, step_all
from .fingertip import Finger as Finger
from .fingertip import FingerOnItsWay, is_possible, sent
from .frame import Frame as Frame
from .rest_shape import Rest
from .skin import Pins, Skin
from .sway import Push, push_of

ANSWERED = 8  # ticks, a fifth of a frame, in which a shape at rest that moves and what meets it go on by themselves
CLOSE = 1e-5  # of its size: a body so near its shape at rest shows no dent


class Session:
    """Run one model, or a proxy of it that carries its skin along.

    model: what is pressed.
    proxy: what moves in its place, None where it moves itself.
    body: what moves, and owns its state.
    backend: "native" (single precision) or "native64".
    contact_note: "" or what is left out of its self contact, for the artist.
    held_note: "" or which colliders could not go their way in the last step, for the artist.
    frame: what the last step showed.
    most: ticks in a motion of the step under way.
    clock: which the fingertips go by.
    rides: nothing touches the body and it sways: it lies on its shape at rest, and is not stepped.
    """

    def __init__(
        self, model: Model, *, tick: float = TICK, backend: str = "native", proxy: Proxy | None = None
    ) -> None:
        self.clock = Clock(tick)
        self.backend, self.contact_note, self.held_note = backend, "", ""
        self.substeps: int  # in a tick
        self.body = self._create(self._define(model, Rest(model, proxy), proxy), model)
        self.reset()

    def reset(self) -> None:
        """Put the body back to rest, in the shape of its model, and let go of it."""
        if self._rest.bent:  # rebuilt, so that the same motion gives the same bits again
            self.body = self._create(self._moves, self.model)
        self._rest.reset()
        self.rides = False
        self.body.set_state(self._moves.matching.rest)
        self._work, self._total = 0.0, 0
        self.clock.reset()
        self._tips: list[FingerOnItsWay | None] = []  # None where one is lifted
        self._pins.rest_at(self.model.matching.rest)
        self._skin.reset()
        self._met: Push | None = None  # what other surfaces do to it
        self._rate = np.zeros_like(self._moves.matching.rest)
        self._last = motion.Frame((), self.body.model.mesh.volume, 0.0, 0, True)
        self._done, self._note, self.most, self._started = 0, "", MAX_STEPS, time.perf_counter()
        self.frame = self._show((), self.clock.tick)

    def set_fingers(self, fingers: Sequence[Finger | None]) -> None:
        """Say where up to three fingertips are at the end of the next step; None lifts one off.

        Raises:
            DimpleError: too many fingertips, a radius that is not positive, or a position that is not a number.
        """
        if len(fingers) > MAX_FINGERTIPS:
            raise DimpleError("There are at most {most} fingertips.", most=MAX_FINGERTIPS)
        for finger in fingers:
            if finger and not is_possible(finger):
                raise DimpleError("A fingertip needs a place that is a number and a radius greater than 0.")
        self._tips = list(map(sent, [*self._tips, None, None, None], fingers))
        if not any(self._tips):
            self.substeps = self._moves.substeps(self.clock.tick)

    def set_pins(self, positions: Floats) -> None:
        """Say where every input vertex (N, 3) [m] would be at the end of the next step if it were pinned.

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        positions = self._of_mesh(positions)
        if not np.isfinite(positions[self._pins.followed]).all():
            raise DimpleError("A pinned vertex has a position that is not a number.")
        self._pins.target = positions.T

    def set_rest(self, positions: Floats) -> None:
        """Say which shape at rest the input vertices (N, 3) [m] have at the end of the next step, as a rig bends it.

        Where the model is rigged that is also where it is; else only the shape counts.

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        positions = self._of_mesh(positions)
        if not np.isfinite(positions).all():
            raise DimpleError("The shape at rest has a position that is not a number.")
        self._rest.target = positions.T

    def _of_mesh(self, positions: Floats) -> Floats:
        """Return the positions of the mesh's vertices (n, 3) for those of the input vertices (N, 3)."""
        positions = np.asarray(positions, np.float64)
        if positions.shape != (len(self.model.mesh.source), 3):
            raise DimpleError(
                "The mesh has {vertices} vertices: give a position for each.", vertices=len(self.model.mesh.source)
            )
        return self._skin.of_mesh(positions)

    def step(self, dt: float, *, budget: float | None = None) -> Frame:
        """Advance by dt [s] in whole ticks; what is left over is carried to the next call.

        Args:
            budget: wall time [s] that only a first tick may exceed; what is not done lags behind.

        Raises:
            DimpleError: dt is negative or not a number.
        """
        return step_all([self], [dt], budget=budget)[0]

    def begin(self, dt: float, *, alone: bool = True) -> None:
        """Begin a step of dt [s]; its ticks follow in motions, and `finish` ends it.

        Args:
            alone: it meets nothing but its fingertips.

        Raises:
            DimpleError: dt is negative or not a number.
        """
        self.clock.start(dt)
        self._ride(alone and not any(self._tips))
        self._met = None if alone else self._met
        self._done, self._note, self._started = 0, "", time.perf_counter()
        meets = not alone or any(self._tips)
        self.most = ANSWERED if meets and (self._rest.sway or self._rest.moves) else MAX_STEPS // self.substeps - 1
        for tip in self._tips:
            if tip:
                tip.impulse = ZERO
                if tip.target.via:  # it turns at each of them
                    self.most = max(1, min(self.most, self.clock.due // (len(tip.target.via) + 1)))

    @property
    def due(self) -> int:
        """Return how many ticks of the step under way are left."""
        return 0 if self._note else self.clock.due

    def next_motion(self, ticks: int, *, substeps: int = 0) -> Motion:
        """Return what happens in some ticks of the step under way.

        Args:
            substeps: in each of them, if not as many as the model needs.
        """
        clock = self.clock
        pushes = self._pushes() if self._rest.sway else []
        if ticks and (self._rest.moves or pushes):
            self._bend(ticks, pushes)
        if self.rides:
            return Motion(ticks, self.substeps, clock.tick, (None,) * len(self._tips))
        first = last = clock.share_after(ticks)
        if ticks > 1:
            first = max(clock.share_after(1), 0.0)  # it may begin before the step does
        pins = self._pins.lead(first, last)
        return Motion(ticks, substeps or self.substeps, clock.tick, self._motions(first, last), pins)

    def take(self, result: motion.Frame) -> bool:
        """Take what a motion came to; tell whether the step goes on."""
        self._last = result
        self.clock.ticks += result.ticks
        self._done += result.ticks
        self._total += result.ticks * self.substeps
        if result.moved:
            self._skin.reset()
        self._pins.take()
        for tip, touch in zip(self._tips, result.touches, strict=True):
            if tip and touch:
                self._work += tip.take(touch, result.ticks * self.clock.tick)
        if not result.finite:
            at, done = self.clock.ticks * self.clock.tick, self._done
            self.reset()
            note = Message(
                "The simulation blew up after {at:.3f} s and was put back to rest. Lower k or K2, or raise the mass.",
                at=at,
            )
            self._done, self._note = done, note
        return result.finite

    def finish(self, *, early: bool = False) -> Frame:
        """End the step under way, or what has been done of it, and return what it shows."""
        if not self._note:
            if not self._done:
                self._last = self._measured()
            self._move_origins(self.clock.stop(early=early))
        impulses, seconds = self.frame.impulses, self.frame.seconds  # as before where no tick was due
        if self._done or len(impulses) != len(self._tips):
            impulses = tuple([tip.impulse if tip else ZERO for tip in self._tips])
            seconds = max(self._done, 1) * self.clock.tick
        self.frame = self._show(impulses, seconds)
        return self.frame

    def bent_model(self) -> Model:
        """Return the model that moves, with the shape at rest that a rig has given it."""
        return with_rest(self._moves, self._rest.of_body) if self._rest.bent else self._moves

    @property
    def moved(self) -> bool:
        """Tell whether anything moved in the last step; False where the body slept all the time."""
        return self._last.moved or (self.rides and self._rest.moves)

    @property
    def sway_hz(self) -> float:
        """Return how often the body sways in a second in its slowest way [Hz], 0 where it does not."""
        return self._rest.sway.frequency if self._rest.sway else 0.0

    def wake(self) -> None:
        """Let the body move again where it sleeps: what it rested on may be gone."""
        self._ride(False)
        self.body.wake()

    @property
    def placed(self) -> tuple[Finger | None, ...]:
        """Return where the fingertips are: those that a force pushes are where it has pushed them."""
        return tuple([tip.finger() if tip else None for tip in self._tips])

    @property
    def fingers(self) -> tuple[Finger | None, ...]:
        """Return where the fingertips are to be at the end of the next step."""
        return tuple([tip.target if tip else None for tip in self._tips])

    def law(self, index: int, depths: Sequence[float]) -> list[float]:
        """Return the forces [N] of the law on a fingertip that is down, if it were at depths [m] where it is."""
        tip = self._tips[index]
        assert tip
        table = factors(self.model.materials, tip.target.radius, self.model.mesh.size)
        return self.body.law(index, np.asarray(depths), table).tolist()

    def positions(self) -> Singles:
        """Return where the input vertices (N, 3) [m] are, to be read: the same array as long as nothing moves."""
        self._lay()
        return self._skin.positions(self.body, self.placed)

    def change(self, model: Model, *, proxy: Proxy | None = None, scale: float = 1.0) -> None:
        """Go on as another model of the same vertices, from where the body is: nothing moves at the change.

        A vertex that is pinned by it stays where it is then, until pins are led elsewhere.

        Args:
            proxy: what moves in place of the new model, None where it moves itself.
            scale: by which all lengths of the new model are larger.

        Raises:
            DimpleError: it cannot be simulated, or has other vertices; the body goes on as it was.
        """
        moves, before, surface = proxy.model if proxy else model, self.body.model, self.model
        moves.substeps(self.clock.tick)
        if len(model.matching.rest.T) != len(surface.matching.rest.T):
            raise DimpleError("The mesh has other vertices than when it was started. Reset it and start again.")
        self._ride(False)
        skin = scale * np.asarray(self._skin.surface(self.body), np.float64)
        led = self._pins.target
        if model.mesh is surface.mesh and moves.mesh is before.mesh:
            self.body.set_constants(moves, surface=model)
        else:
            at, speed = skin, scale * self._skin.velocities(self.body)
            if proxy:
                at, speed = at[proxy.seeds], speed[proxy.seeds]
            self.body = self._create(moves, model)
            self.body.set_state(at.T, speed.T)
            for tip in filter(None, self._tips):
                tip.scale(scale)
            led = None
        self._define(model, Rest(model, proxy, self._rest), proxy)
        if self._rest.bent and moves.mesh is not before.mesh:
            self._lay_rest()
        if self._rest.bent and self._rest.sway:
            self._rate = self._rest.rate_of_body
        self._pins.origin, self._pins.target = skin.T, led

    def _define(self, model: Model, rest: Rest, proxy: Proxy | None) -> Model:
        """Set what follows from a model, its shape at rest and its proxy; return the one that moves."""
        moves = proxy.model if proxy else model
        self.substeps = moves.substeps(self.clock.tick)
        self.model, self.proxy, self._moves = model, proxy, moves
        self._volume_scale = model.mesh.volume / moves.mesh.volume if moves.mesh.volume > 0 else 1.0
        self._rest, self._met = rest, None
        self._rate = np.zeros_like(moves.matching.rest)  # of the shape at rest (3, m), in the last motion [m/s]
        self._pins: Pins = Pins(model, proxy)
        self._skin: Skin = Skin(model, proxy, self._pins, rest)
        return moves

    def _create(self, moves: Model, surface: Model) -> Body:
        return create(moves, surface=surface, backend=self.backend)

    def _move_origins(self, share: float) -> None:
        for tip in self._tips:
            if tip:
                tip.origin, tip.target = tip.place(share), tip.target._replace(via=(), fresh_contact=False)
        if self._pins.move(share):
            self._skin.reset()

    def _motions(self, first: float, last: float) -> tuple[motion.FingertipMotion | None, ...]:
        """Return the motion of each fingertip in some ticks."""
        materials, size = self.model.materials, self.model.mesh.size
        return tuple([
            tip.motion(first, last, factors(materials, tip.target.radius, size)) if tip else None for tip in self._tips
        ])  # fmt: skip

    def _measured(self) -> motion.Frame:
        """Measure fingertips that were put down or lifted without a tick."""
        return self.body.step(Motion(0, self.substeps, self.clock.tick, self._motions(0.0, 0.0)))

    def meet(self, impulses: Floats, seconds: float) -> None:
        """Let a body that sways give way to what others gave its vertices (m, 3) in some seconds [N s]."""
        if self._rest.sway:
            self._met = self._rest.sway.met(impulses, seconds, self.proxy.seeds if self.proxy else None)

    def _pushes(self) -> list[Push]:
        """Return what others and the fingertips that touch do to a body that sways."""
        tips, mesh = zip(self._tips, self._last.touches, strict=False), self.model.mesh
        pushes = [push_of(touch, tip.target, mesh) for tip, touch in tips if tip and touch and any(touch.force)]
        return [*pushes, self._met] if self._met and len(self._met.vertices) else pushes

    def _bend(self, ticks: int, pushes: Sequence[Push]) -> None:
        """Let the shape at rest go on in the ticks that follow, and the body with it."""
        seconds = ticks * self.clock.tick
        share, left = self.clock.share_after(ticks), 1 - max(self.clock.share_after(0), 0.0)
        before = None if self.rides else self._rest.of_body
        self._rest.advance(1.0 if share >= 1 else 1 - (1 - share) / left, seconds, pushes)
        if before is not None:
            rate, rate_before = (self._rest.of_body - before) / seconds, self._rate
            self._rate = rate
            self._lay_rest(rate, gain=rate - rate_before if self._rest.sway else None)  # modes have the inertia
        else:
            self._skin.laid = None
            self._skin.reset()

    def _ride(self, wanted: bool) -> None:
        """Leave a body that sways to its shape at rest where nothing shows that it is not on it, or step it again."""
        rest = self._rest
        if wanted and rest.sway and not self.rides:
            off = self.body.positions() - rest.of_body
            self.rides = float(np.abs(off).max()) <= CLOSE * self.model.mesh.size
        elif self.rides and not wanted:
            self.rides, self._skin.laid, self._rate = False, None, rest.rate_of_body
            self._lay_rest()
            self.body.set_state(rest.of_body, self._rate)

    def _lay_rest(self, rate: Floats | None = None, *, gain: Floats | None = None) -> None:
        """Give the body its shape at rest, at a rate (3, m) in the next motion, and speeds (3, m) more [m/s]."""
        self.body.set_rest(self._rest.of_body, rate, surface=self._rest.whole if self.proxy else None, gain=gain)

    def _lay(self) -> None:
        """Let the skin lie on the shape at rest where the body rides on it."""
        if self.rides and self._skin.laid is None:
            self._skin.laid = self._rest.whole

    def skin(self) -> Floats:
        """Return where the vertices (n, 3) [m] of the mesh are."""
        self._lay()
        return np.asarray(self._skin.on(self.placed, self._skin.surface(self.body)), np.float64)

    def _show(self, impulses: tuple[Vector, ...], seconds: float) -> Frame:
        last, scale, rest = self._last, self._volume_scale, self.model.mesh.volume
        if self._rest.bent and not self.rides:  # asking the body costs a call
            rest = self.body.rest_volume * scale
        return Frame(
            self.clock.time, impulses, seconds, last.touches, self.model.mesh, last.pressure, last.volume * scale, rest,
            self.substeps, self._done, time.perf_counter() - self._started, self._total, self._work,
            self._note,
        )  # fmt: skip
