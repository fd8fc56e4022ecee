"""The numpy twin of the native core: the same body, the same calls, to be read and tested against."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from core.base import FINGER_TRAVEL, Bools, Floats, Ints
from core.body import pressure
from core.body.model import Model, State, initial_state
from core.body.moved_rest import on_its_way, with_rest
from core.body.shape_matching import Pose, carried_pose, fit_pose
from core.material import law_force
from core.solver.motion import FingertipMotion, Frame, Motion, PinMotion, Touch, Vector

from . import semi_implicit
from .depth import RestSurface, Touching, rest_surface, touching
from .path import FingerPath
from .rest import Rest, reaches

LARGEST_GROWTH = 100.0  # times its size at rest: a body as large has blown up
FASTEST = 1e6  # sizes in a tick: so has one as fast


@dataclass(slots=True, kw_only=True)
class Call:
    """A motion under way.

    motion: what happens.
    down: which fingertips are down.
    here: where each of them is (3,) [m].
    impulses: (k, 3) on the fingertips so far [N s].
    ticks: done.
    finite: False where the body has blown up.
    moved: it was not asleep all the time.
    path: of the fingertips in the tick under way.
    """

    motion: Motion
    down: list[int]
    here: dict[int, Floats]
    impulses: Floats
    ticks: int = 0
    finite: bool = True
    moved: bool = False
    path: FingerPath = field(default_factory=lambda: FingerPath(centres=np.zeros((0, 2, 3)), radii=np.zeros(0)))


class Twin:
    """A body that numpy steps; what it owns and does is said in `native.Body`."""

    def __init__(self, model: Model, *, surface: Model | None = None) -> None:
        self.model, self._fine = model, surface or model
        self._surface: RestSurface = rest_surface(self._fine.mesh)
        self._sides: list[Floats | None] = [None] * 3
        self._moved: Floats | None = None  # the shape at rest, where it is not the model's
        self._rest_rate: Floats | None = None  # in the next motion
        self.sag = 0.0  # [m/s] that gravity gives in a substep, and contact takes back: in a scene
        self.set_state(model.matching.rest)

    def set_constants(self, model: Model, *, surface: Model | None = None) -> None:
        """Give the living body the numbers of other models of the same meshes."""
        old = self.model
        if model.pressure.fill != old.pressure.fill:
            self._state.pressure = 0.0
        if old.free and not model.free:
            self._state.pose = self._pose()
        elif model.free:
            self._state.pose = None
        if model.rigged and not old.rigged:
            self._state.pose = np.eye(3), np.zeros(3)
        self._rest_pins(model.pinned)
        self._fine = surface or (model if self._fine is old else self._fine)
        self.model, self._rest = model, Rest()
        if self._moved is not None:
            self.set_rest(self._moved)

    def set_rest(self, rest: Floats, rate: Floats | None = None) -> None:
        """Give the living body another shape at rest (3, n) [m]: at a rate (3, n) [m/s] in the next motion, or at once.

        Raises:
            ValueError: a proxy, which has a surface of its own.
        """
        if len(self._fine.mesh.rest_positions) != len(self.model.mesh.rest_positions):
            raise ValueError("a proxy has a surface of its own")
        self._moved, self._rest_rate, self._rest = np.array(rest), rate, Rest()
        if rate is not None and self.model.free:  # only the shape counts
            k1 = self.model.matching.k1
            self._rest_rate = rate - (rate @ k1 / max(k1.sum(), 1e-300))[:, None]
        self.model = self._fine = with_rest(self.model, self._moved)
        self._surface = rest_surface(self._fine.mesh)

    def set_load(self, load: Floats | None) -> None:
        """Push each vertex by a force (3, n) [N] from now on, None by none."""
        self._state.load, self._rest = load, Rest()

    @property
    def rest_volume(self) -> float:
        """Return the volume at rest [m3]."""
        return self.model.mesh.volume

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Put the vertices at positions (3, n) [m] with velocities (3, n) [m/s], the shape at rest at rest."""
        state = self._state = initial_state(self.model)
        self._rest_rate = None
        state.positions[:] = positions
        state.velocities[:] = 0.0 if velocities is None else velocities
        self._led, self._rest = False, Rest()

    def positions(self) -> Floats:
        """Return where the vertices are, (3, n) [m]."""
        return self._state.positions.copy()

    def velocities(self) -> Floats:
        """Return how fast the vertices move, (3, n) [m/s]."""
        return self._state.velocities.copy()

    def step(self, motion: Motion) -> Frame:
        """Run the ticks of a motion."""
        call, self.sag = self.begin(motion), 0.0
        while call.ticks < motion.ticks and call.finite:
            path = self.begin_tick(call)
            with np.errstate(all="ignore"):  # the frame says when it has blown up
                if not self._rest.asleep:
                    call.impulses[call.down] += semi_implicit.run(
                        self.model, self._state, path, tick=motion.tick, substeps=motion.substeps
                    )
            self.end_tick(call)
            if self._rest.rested:
                self.fall_asleep(call)
        return self.end(call)

    @property
    def state(self) -> State:
        """Return what moves, for a scene that steps several bodies together."""
        return self._state

    @property
    def rest(self) -> Rest:
        """Return how long it has been at rest, and whether it sleeps."""
        return self._rest

    def wake(self, call: Call) -> None:
        """Let the body move again within a tick."""
        self._rest = Rest()
        self._enter_tick(call)

    def fall_asleep(self, call: Call) -> None:
        """Let the body sleep, unless a fingertip or a pin would wake it."""
        near = self._near(call.path)
        self._rest.under = {i: (call.here[i], r) for i, r, n in zip(call.down, call.path.radii, near, strict=True) if n}
        self._rest.rested, self._rest.asleep = False, not self._is_woken(call)

    def begin(self, motion: Motion) -> Call:
        """Begin a motion; its ticks follow one by one."""
        tips = motion.fingertips
        for i, tip in enumerate((*tips, None, None, None)[:3]):
            if tip is None or tip.fresh:
                self._sides[i] = None
                self._state.kept.pop(i, None)
        if motion.pins is None and self._led and motion.ticks:
            self._rest_pins(self.model.pinned)
        down = [i for i, tip in enumerate(tips) if tip is not None]
        here = {i: np.array(tips[i].start) for i in down}  # type: ignore[union-attr]
        return Call(motion=motion, down=down, here=here, impulses=np.zeros((len(tips), 3)))

    def begin_tick(self, call: Call) -> FingerPath:
        """Lead the pins of a tick and return where the fingertips go in it."""
        motion, tips = call.motion, call.motion.fingertips
        share = call.ticks / (motion.ticks - 1) if motion.ticks > 1 else 0.0
        centres = np.empty((len(call.down), 2, 3))
        for row, i in enumerate(call.down):
            centres[row, 0] = call.here[i]
            centres[row, 1] = call.here[i] = _moved(call.here[i], tips[i], share)
        radii = np.array([tips[i].radius for i in call.down])  # type: ignore[union-attr]
        path = FingerPath(centres=centres, radii=radii, fingers=tuple(call.down))
        call.path = path
        if self._rest.asleep and self._is_woken(call):
            self._rest = Rest()
        if not self._rest.asleep:
            self._enter_tick(call)
        return path

    def _enter_tick(self, call: Call) -> None:
        motion, call.moved = call.motion, True
        self._state.pushes = np.zeros((len(call.down), 3))
        if self._rest_rate is not None:
            left = motion.ticks - call.ticks - (1 - 1 / motion.substeps) / 2
            self.model = on_its_way(self.model, self._rest_rate, left * motion.tick)
        if motion.pins:
            share = call.ticks / (motion.ticks - 1) if motion.ticks > 1 else 0.0
            self._lead_pins(motion, motion.pins, share)

    def end_tick(self, call: Call) -> None:
        """Count a tick, and see whether the body is still whole, or has come to rest."""
        call.ticks += 1
        if self._rest.asleep:
            for i in self._rest.under:
                call.impulses[i] += self._rest.held[i] * call.motion.tick
            return
        state, tick, path = self._state, call.motion.tick, call.path
        self._rest.held = np.zeros_like(call.impulses)
        self._rest.held[call.down] = state.pushes
        with np.errstate(all="ignore"):
            call.finite = self._is_finite(tick)
        if call.finite:
            size, led = self.model.mesh.size, call.motion.pins is not None or self._rest_rate is not None
            held = len(path.radii) > 0 and bool((path.centres[:, 0] == path.centres[:, 1]).all())
            self._rest.watch(state.positions, state.velocities, size, tick, led=led, sag=self.sag, held=held)

    def _force(self, finger: int) -> Vector:
        """Return the force on a fingertip in the last substep (3,) [N]."""
        rest = self._rest
        presses = finger < len(rest.held) and (not rest.asleep or finger in rest.under)
        return _three(rest.held[finger] if presses else np.zeros(3))

    def end(self, call: Call) -> Frame:
        """End a motion and return what it came to."""
        motion, tips, down, state = call.motion, call.motion.fingertips, call.down, self._state
        if self._rest_rate is not None and motion.ticks:
            self.model, self._rest_rate = on_its_way(self.model, self._rest_rate, 0.0), None
            self.model = self._fine = replace(self.model, matching=replace(self.model.matching, rate=None))
        if motion.pins and call.moved:
            self._arrive(motion.pins)
        found: list[Touch | None] = [None] * len(tips)
        for i in down if call.finite else ():
            touch = self._touching(tips, i, call.here[i])
            found[i] = Touch(
                _three(call.impulses[i]), _three(call.here[i]), touch.depth, _three(touch.outward), self._law(touch),
                touch.triangle, self._force(i),
            )  # fmt: skip
        pose = self._pose() if call.finite and down else (np.zeros((3, 3)), np.zeros(3))
        return Frame(
            touches=tuple(found), pose=(*pose[0].ravel().tolist(), *pose[1].tolist()),
            volume=self._volume(call.ticks) if call.finite else 0.0, pressure=state.pressure, ticks=call.ticks,
            finite=call.finite, moved=call.moved,
        )  # fmt: skip

    def _is_woken(self, call: Call) -> bool:
        """Tell whether a fingertip, or a pin that is led elsewhere, wakes the body in the tick that begins."""
        pins, path = call.motion.pins, call.path
        if pins and not np.array_equal(self._state.positions[:, self.model.pinned], pins.end):
            return True
        rests = [
            self._rest.lies_under(i, end, radius)
            for i, end, radius in zip(call.down, path.centres[:, 1], path.radii, strict=True)
        ]
        return sum(rests) < len(self._rest.under) or bool((self._near(path) & ~np.array(rests, bool)).any())

    def _near(self, path: FingerPath) -> Bools:
        """Tell which fingertips (k,) come near the box round the body in a tick."""
        used = self._state.positions[:, ~self.model.mesh.loose]
        ways = zip(path.centres[:, 0], path.centres[:, 1], path.radii, strict=True)
        return np.array([reaches(used, start, end, radius) for start, end, radius in ways], bool)

    def _volume(self, ticks: int) -> float:
        known = self.model.pressure.fill != "none" and ticks
        return self._state.volume if known else pressure.volume(self.model.pressure, self._state.positions)

    def _pose(self) -> Pose:
        """Return where the shape at rest is now."""
        matching = self.model.matching
        weight = matching.k1 if matching.k1.any() else matching.mass
        return self._state.pose or fit_pose(matching.rest, self._state.positions, weight, matching.pull)

    def _touching(self, tips: tuple[FingertipMotion | None, ...], i: int, centre: Floats) -> Touching:
        """Return how a fingertip meets the surface at rest, and remember by which side it came in."""
        radius = tips[i].radius  # type: ignore[union-attr]
        touch = touching(self._surface, self._pose(), centre, radius, self._sides[i])
        if touch.depth < radius:  # its centre is still outside
            self._sides[i] = self._surface.normals[:, touch.triangle] if touch.depth > 0 else None
        return touch

    def _law(self, touch: Touching) -> float:
        material = int(self._fine.mesh.triangle_material[touch.triangle])
        return law_force(touch.depth, *self._fine.laws[material])

    def _lead_pins(self, motion: Motion, pins: PinMotion, share: float) -> None:
        """Give the pins of a tick the velocity that brings them to their place, and the shape at rest with them."""
        state, model = self._state, self.model
        pinned = model.pinned
        at = pins.first + share * (pins.last - pins.first)
        way = pins.start + at * (pins.end - pins.start) - state.positions[:, pinned]
        state.velocities[:, pinned] = way / motion.tick
        if state.pose is not None and not model.rigged:
            used = ~model.mesh.loose[pinned]
            here = state.positions[:, pinned][:, used]
            state.pose, state.pose_rate = carried_pose(
                model.mesh.rest_positions.T[:, pinned][:, used], here, here + way[:, used],
                tick=motion.tick, substeps=motion.substeps,
            )  # fmt: skip

    def _arrive(self, pins: PinMotion) -> None:
        """Put pins that have arrived where they were sent, to the last digit."""
        self._led = True
        if pins.last < 1:
            return
        pinned = self.model.pinned
        self._state.positions[:, pinned] = pins.end
        if self._state.pose is not None and not self.model.rigged:
            used: Ints = np.flatnonzero(~self.model.mesh.loose[pinned])
            rest = self.model.mesh.rest_positions.T[:, pinned][:, used]
            self._state.pose = fit_pose(rest, pins.end[:, used], np.ones(len(used)))

    def _rest_pins(self, pinned: Floats | np.ndarray) -> None:
        self._state.velocities[:, pinned] = 0.0
        self._state.pose_rate, self._led = None, False

    def _is_finite(self, tick: float) -> bool:
        """Tell whether every number is finite and the body neither far larger than at rest nor far too fast."""
        state, mesh = self._state, self.model.mesh
        speed = float(np.sqrt((state.velocities**2).sum(axis=0).max()))
        if not (np.isfinite(state.positions).all() and speed * tick < FASTEST * mesh.size):
            return False
        used = state.positions[:, ~mesh.loose]
        return bool(np.ptp(used, axis=1).max() < LARGEST_GROWTH * mesh.size)


def _moved(here: Floats, tip: FingertipMotion | None, share: float) -> Floats:
    """Return where a fingertip is a tick later, no farther than it may go without skipping a skin."""
    assert tip is not None
    first = np.array(tip.first)
    way = first + share * (np.array(tip.last) - first) - here
    most = FINGER_TRAVEL * tip.radius
    return here + way * min(1.0, most / max(math.hypot(*way), 1e-30))


def _three(a: Floats) -> tuple[float, float, float]:
    x, y, z = a.tolist()
    return x, y, z
