"""The numpy twin of the native core: the same body, the same calls, to be read and tested against."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from core.base import Bools, Floats, Ints
from core.body import pressure
from core.body.model import Model
from core.body.moved_rest import with_rest
from core.body.shape_matching import Pose, fit_pose
from core.material import law_force
from core.native.motion import FingertipMotion, Frame, Motion, PinMotion, Touch

from . import fingertip, semi_implicit
from .constants import LARGEST_GROWTH, REST_TIME, TRAVEL
from .contact import Step
from .contact import Touch as Near
from .fingertip import Around, RestSurface, Tip, rest_surface
from .laws import State, carried_pose, initial_state, on_its_way
from .path import FingerPath
from .rolling import Turning
from .sleep import Rest, reaches
from .ticks import each_tick, meet, moved_back, slow_down


@dataclass(slots=True, kw_only=True)
class Call:
    """A motion under way.

    motion: what happens.
    down: which fingertips are down.
    here: where each of them is (3,) [m].
    impulses: (3, 3) on the fingertips so far [N s].
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
        self._tips = [Tip() for _ in range(3)]
        self._surface: RestSurface = self._lay_surface()
        self._fitted: Pose = np.eye(3), np.zeros(3)  # as the substep began
        self.meets = False  # it is in a scene
        self.turning = Turning(model.mesh.size)
        self._moved: Floats | None = None  # the shape at rest, where it is not the model's
        self._rest_rate: Floats | None = None  # in the next motion
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
        self.turning.fill = None
        self._fine = surface or model
        self.model, self._rest = model, Rest()
        if self._moved is not None:
            self.model = self._fine = with_rest(model, self._moved)
        self._surface = self._lay_surface(self._surface.order)

    def _lay_surface(self, order: Ints | None = None) -> RestSurface:
        fine, maps = self._fine, self._fine.maps
        painted = maps and np.column_stack([maps.stiffer, maps.deeper])
        return rest_surface(fine.mesh, fine.laws, painted, float(self.model.matching.mass.sum()), order)

    def set_rest(self, rest: Floats, rate: Floats | None = None, *, gain: Floats | None = None) -> None:
        """Give the living body another shape at rest (3, n) [m]: at a rate (3, n) [m/s] in the next motion, or at once;
        its speeds grow by a gain (3, n) [m/s].

        Raises:
            ValueError: a proxy, which has a surface of its own.
        """
        if gain is not None:
            self._state.velocities += np.where(self.model.inverse_mass > 0, gain, 0.0)
        if len(self._fine.mesh.rest_positions) != len(self.model.mesh.rest_positions):
            raise ValueError("a proxy has a surface of its own")
        self._moved, self._rest_rate, self._rest = np.array(rest), rate, Rest()
        self.turning.fill = None
        if rate is not None and self.model.free:  # only the shape counts
            k1 = self.model.matching.k1
            self._rest_rate = rate - (rate @ k1 / max(k1.sum(), 1e-300))[:, None]
        self.model = self._fine = with_rest(self.model, self._moved)
        before, self._surface = self._surface, self._lay_surface(self._surface.order)
        for tip in self._tips:
            fingertip.go_along(tip, before, self._surface)

    @property
    def rest_volume(self) -> float:
        """Return the volume at rest [m3]."""
        return self.model.mesh.volume

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Put the vertices at positions (3, n) [m] with velocities (3, n) [m/s], the shape at rest at rest."""
        state = self._state = initial_state(self.model)
        self._rest_rate = self.turning.fill = None
        state.positions[:] = positions
        state.velocities[:] = 0.0 if velocities is None else velocities
        self._led, self._rest = False, Rest()
        self._comes_back = 0.0  # [s] for so long its skin does, since nothing touches it: about
        for tip in self._tips:
            fingertip.lift(tip)

    def positions(self) -> Floats:
        """Return where the vertices are, (3, n) [m]."""
        return self._state.positions.copy()

    def velocities(self) -> Floats:
        """Return how fast the vertices move, (3, n) [m/s]."""
        return self._state.velocities.copy()

    def step(self, motion: Motion) -> Frame:
        """Run the ticks of a motion."""
        call, self.meets, self.turning.moment = self.begin(motion), False, np.zeros(3)
        while call.ticks < motion.ticks and call.finite:
            touches = self.begin_tick(call)
            for left in reversed(range(motion.substeps)) if not self._rest.asleep else ():
                self.substep(call, touches, left)
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

    def wake(self, call: Call | None = None) -> None:
        """Let the body move again, where there is a call within its tick."""
        self._rest = Rest()
        if call:
            self._enter_tick(call)

    def fall_asleep(self, call: Call) -> None:
        """Let the body sleep, unless a fingertip or a pin would wake it."""
        near = self._near(call.path)
        self._rest.under = {i: (call.here[i], r) for i, r, n in zip(call.down, call.path.radii, near, strict=True) if n}
        self._rest.rested, self._rest.asleep = False, not self._is_woken(call)

    def begin(self, motion: Motion) -> Call:
        """Begin a motion; its ticks follow one by one."""
        tips = motion.fingertips
        for i, to in enumerate((*tips, None, None, None)[:3]):
            if to is None or to.fresh:
                self._state.kept.pop(i, None)
            fingertip.take(self._around(i), self._tips[i], to)
        if motion.pins is None and self._led and motion.ticks:
            self._rest_pins(self.model.pinned)
        down = [i for i, tip in enumerate(tips) if tip is not None]
        here = {i: self._tips[i].centre.copy() for i in down}
        return Call(motion=motion, down=down, here=here, impulses=np.zeros((3, 3)))

    def begin_tick(self, call: Call) -> list[Near]:
        """Lead the pins of a tick and return what the fingertips may touch in it."""
        motion, tips = call.motion, call.motion.fingertips
        share = call.ticks / (motion.ticks - 1) if motion.ticks > 1 else 0.0
        centres = np.empty((len(call.down), 2, 3))
        for row, i in enumerate(call.down):
            to, tip = tips[i], self._tips[i]
            assert to
            if to.force > 0:
                fingertip.push_on(self._surface, self._pose(), tip, to, motion.tick)
            centres[row, 0] = call.here[i]
            centres[row, 1] = tip.centre = call.here[i] = _moved(call.here[i], to, share, tip.way)
        radii = np.array([tips[i].radius for i in call.down])  # type: ignore[union-attr]
        path = FingerPath(centres=centres, radii=radii, fingers=tuple(call.down))
        call.path = path
        if self._rest.asleep and self._is_woken(call):
            self._rest = Rest()
        if not self._rest.asleep:
            self._enter_tick(call)
        return self.near(call)

    def near(self, call: Call) -> list[Near]:
        """Return what the fingertips may touch in the tick under way."""
        return next(each_tick(self.model, self._state, call.path, call.motion.tick))

    def substep(self, call: Call, touches: list[Near], left: int) -> None:
        """Advance the body by a substep after which so many come in the tick, fingertips included."""
        try:
            with np.errstate(all="ignore"):  # the frame says when it has blown up
                self._advance(call, touches, left)
        except np.linalg.LinAlgError:  # no rigid motion fits a body that has blown up
            self._state.positions[:] = np.nan

    def _advance(self, call: Call, touches: list[Near], left: int) -> None:
        model, state, dt = self.model, self._state, call.motion.tick / call.motion.substeps
        before = state.positions.copy()
        near = [h for h in touches if len(h.vertices) or len(h.triangles)]
        limit = min((h.radius for h in near), default=np.inf) * 2 * TRAVEL
        if model.free:
            self._fitted = self._pose()
            self._press_free(call, touches, left + 1, dt)
            turning, turn = self.turning, self._fitted[0]
            turning.measure(model.matching.mass, before, state.velocities)
            turning.turn_fill(turn @ model.fill_momentum @ turn.T, dt)
        semi_implicit.advance(model, state, dt)
        if model.free:
            by = np.where(model.inverse_mass > 0, dt * turning.acceleration(before), 0.0)
            state.velocities -= by
            state.positions -= dt * by
        if near:
            slow_down(before, state.positions, limit)
        now = [replace(h, slides=self._tips[i].slides) for i, h in zip(call.down, touches, strict=True)]
        given = meet(model, state, moved_back(now, left * dt), Step(dt, limit))
        if model.free and call.down:
            self._react(given.sum(axis=0), dt)

    def _press_free(self, call: Call, touches: list[Near], left: int, dt: float) -> None:
        """Evaluate the contacts of a free body, as a substep begins after which the tick has so many less one."""
        for i, near in zip(call.down, touches, strict=True):
            fingertip.press(self._around(i), self._tips[i], near.centre - left * dt * near.velocity, dt)
            fingertip.count_anew(self._tips[i], dt, others=self._is_beside_others(i))
            call.impulses[i] += dt * self._tips[i].force

    def _press_held(self, call: Call) -> None:
        """Evaluate the contacts of a body that is held, or sleeps, at the end of a tick."""
        (rotation, translation), rate, tick = self._pose(), self._state.pose_rate, call.motion.tick
        if rate is not None and not self._rest.asleep:  # the body stands where its substeps began on average
            share = tick - (tick - tick / call.motion.substeps) / 2
            rotation, translation = rotation + share * rate[0], translation + share * rate[1]
        for i in call.down:
            fingertip.press(self._around(i, (rotation, translation)), self._tips[i], call.here[i])
            fingertip.count_anew(self._tips[i], tick, others=self._is_beside_others(i))
            call.impulses[i] += tick * self._tips[i].force

    def _react(self, given: Floats, dt: float) -> None:
        """Let the vertices take, as one, what is missing to the reaction on the fingertips.

        Args:
            given: impulse on the fingertips by the skin's contact, and its moment (2, 3) [N s], [N m s].
        """
        model, state, (rotation, translation) = self.model, self._state, self._fitted
        push, turn = given.copy()
        for tip in self._tips:
            place = rotation @ (tip.foot - tip.radius * tip.outward) + translation
            push -= dt * tip.force
            turn -= dt * np.cross(place, tip.force)
        now = Turning(model.mesh.size)
        now.measure(model.matching.mass, state.positions, state.velocities)
        now.moment = turn - np.cross(now.centre, push)
        more = (push / model.matching.mass.sum())[:, None] + now.acceleration(state.positions)
        state.velocities += np.where(model.inverse_mass > 0, more, 0.0)

    def _around(self, finger: int, pose: Pose | None = None) -> Around:
        own, kept = self._fine.mesh is self.model.mesh, self._state.kept.get(finger)
        return Around(
            surface=self._surface, pose=pose or self._pose(), skin=self._state.positions,
            rest=None if own else self.model.mesh.rest_positions.T, pushes=kept is not None and bool(kept.any()),
            others=self._comes_back > 0 or self._is_beside_others(finger),
        )  # fmt: skip

    def _is_beside_others(self, finger: int | None) -> bool:
        return self.meets or any(tip.in_contact for k, tip in enumerate(self._tips) if k != finger)

    def _enter_tick(self, call: Call) -> None:
        motion, call.moved = call.motion, True
        if self._rest_rate is not None:
            left = motion.ticks - call.ticks - (1 - 1 / motion.substeps) / 2
            self.model = on_its_way(self.model, self._rest_rate, left * motion.tick)
            self._state.rest_rate = self._rest_rate
        if motion.pins:
            share = call.ticks / (motion.ticks - 1) if motion.ticks > 1 else 0.0
            self._lead_pins(motion, motion.pins, share)

    def end_tick(self, call: Call) -> None:
        """Count a tick, and see whether the body is still whole, or has come to rest."""
        call.ticks += 1
        if not self.model.free or self._rest.asleep:
            self._press_held(call)
        back = self._comes_back - call.motion.tick
        self._comes_back = REST_TIME if self._is_beside_others(None) else back
        if self._rest.asleep:
            return
        state, tick = self._state, call.motion.tick
        with np.errstate(all="ignore"):
            call.finite = self._is_finite(tick)
        if call.finite:
            size, led = self.model.mesh.size, call.motion.pins is not None or self._rest_rate is not None
            self._rest.watch(state.positions, state.velocities, size, tick, led=led)

    def end(self, call: Call) -> Frame:
        """End a motion and return what it came to."""
        motion, tips, down, state = call.motion, call.motion.fingertips, call.down, self._state
        if self._rest_rate is not None and motion.ticks:
            self.model = self._fine = on_its_way(self.model, self._rest_rate, 0.0)
            self._rest_rate = state.rest_rate = None
        if motion.pins and call.moved:
            self._arrive(motion.pins)
        for i in down if not motion.ticks else ():
            fingertip.press(self._around(i), self._tips[i], call.here[i])
        return Frame(
            touches=tuple(self._touch(i, call) if i in down else None for i in range(len(tips))),
            volume=self._volume(call.ticks) if call.finite else 0.0, pressure=state.pressure, ticks=call.ticks,
            finite=call.finite, moved=call.moved,
        )  # fmt: skip

    def _touch(self, i: int, call: Call) -> Touch:
        """Return how a fingertip meets the body at the end of a call."""
        tip, impulse, none = self._tips[i], _three(call.impulses[i]), (0.0, 0.0, 0.0)
        if not call.finite:
            return Touch(impulse, none, 0.0, none, none, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0), -1)
        k1, k2, x0, power, friction, *_ = self._surface.laws[self._surface.materials[tip.facet]].tolist()
        plain = law_force(tip.depth, k1, k2, x0 * tip.deeper, power)
        times = tip.law / plain if tip.law > 0 and plain > 0 else tip.stiffer
        return Touch(
            impulse, _three(tip.centre), tip.depth, _three(self._pose()[0] @ tip.outward), _three(tip.force), tip.slope,
            friction, (times * k1, times * k2, x0 * tip.deeper, power), int(self._surface.order[tip.facet]),
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
        known = bool(self.model.pressure.kind) and ticks
        here = self._state.positions
        return self._state.volume if known else pressure.volume_and_gradient(self.model.pressure, here)[0]

    def _pose(self) -> Pose:
        """Return where the shape at rest is now."""
        matching = self.model.matching
        weight = matching.k1 if matching.k1.any() else matching.mass
        return self._state.pose or fit_pose(matching.rest, self._state.positions, weight, matching.pull)

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
        """Tell whether every number is finite and nothing far too fast or too far from where it rests."""
        state, mesh = self._state, self.model.mesh
        speed = float(np.sqrt((state.velocities**2).sum(axis=0).max()))
        if not (np.isfinite(state.positions).all() and speed * tick < LARGEST_GROWTH * mesh.size):
            return False
        rotation, translation = self._pose()
        ways = state.positions - rotation @ self.model.matching.rest - translation[:, None]
        farthest = (ways**2).sum(axis=0)[self.model.matching.k1 > 0].max(initial=0)
        return bool(np.sqrt(farthest) < LARGEST_GROWTH * mesh.size)


def _moved(here: Floats, tip: FingertipMotion, share: float, pushed: float) -> Floats:
    """Return where a fingertip is a tick later, no farther than it may go without skipping a skin.

    Args:
        pushed: how far a force has pushed it [m].
    """
    first = np.array(tip.first)
    way = first + share * (np.array(tip.last) - first) - here
    if tip.force > 0:
        way += pushed * np.array(tip.inward)
    most = TRAVEL * tip.radius
    return here + way * min(1.0, most / max(math.hypot(*way), 1e-30))


def _three(a: Floats) -> tuple[float, float, float]:
    x, y, z = a.tolist()
    return x, y, z
