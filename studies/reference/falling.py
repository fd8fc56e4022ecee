"""Props that fall, and what they stand on: the ground, colliders and each other, none of which gives.

A prop of mass m goes on by its velocity v and its spin w = R I^-1 R^T L. Where two come as near as they touch, impulses
pass between points that lie at arms r from their centres, as between soft bodies (`touching.py`), with

    1 / mass = sum over both of 1 / m + (r x n) . R I^-1 R^T (r x n)

They are taken one after the other, over and over, from those of the last substep, until nothing changes any more.
Soft bodies meet a prop as a collider that goes at its speed; what they answer acts in the next substep.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from core.base import Floats, Ints
from core.body.rigid import RigidState
from core.native.scene import Fall, Falling

from .constants import BACK, EXACT, HELD, REST_SPEED, REST_TIME, ROLL_ARM, ROUNDING, SWEEPS
from .rigid import rotation

SIDES = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]])  # of the ground
NOBODY = -1  # surface of the ground


@dataclass(slots=True, eq=False)
class Prop:
    """A prop that moves.

    what: it is.
    radius: how far its farthest vertex is from its centre [m].
    at_start: inverse of its inertia, as it lies where it has not turned.
    fall: how it moves in this call.
    inverse: of its inertia, as it lies now.
    spin: (3,) [1/s].
    answer: (6,) impulse [N s], and moment about the centre, that soft bodies gave it in a substep.
    apart: (6,) way [m] and turn by which it is brought apart in this substep.
    quiet, still: [s] since it was slow last, and its centre and turn then.
    """

    what: Falling
    fall: Fall | None = None
    inverse: Floats = field(default_factory=lambda: np.eye(3))
    spin: Floats = field(default_factory=lambda: np.zeros(3))
    answer: Floats = field(default_factory=lambda: np.zeros(6))
    apart: Floats = field(default_factory=lambda: np.zeros(6))
    quiet: float = 0.0
    still: tuple[Floats, Floats] | None = None
    rested: bool = False
    asleep: bool = False
    radius: float = field(init=False)
    at_start: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.radius = float(np.linalg.norm(self.what.seen, axis=1).max())
        self.at_start = np.asarray(np.linalg.inv(self.what.shape.inertia), np.float64)

    @property
    def state(self) -> RigidState:
        assert self.fall
        return self.fall.state

    def speed(self) -> float:
        """Return how fast any of it may be [m/s]."""
        return float(np.linalg.norm(self.state.velocity) + np.linalg.norm(self.spin) * self.radius)

    def begin(self, dt: float) -> None:
        """Begin a substep: weight, and what soft bodies answered in the last one."""
        assert self.fall
        state, mass = self.state, self.what.shape.mass
        left = 1 / (1 + dt * self.what.damping / mass) if self.answer.any() else 1.0
        state.velocity = left * state.velocity + dt * self.fall.gravity + self.answer[:3] / mass
        state.momentum = left * state.momentum + self.answer[3:]
        self.inverse = state.turn @ self.at_start @ state.turn.T
        self.spin, self.apart = self.inverse @ state.momentum, np.zeros(6)

    def push(self, impulse: Floats, arm: Floats, moment: Floats | None = None) -> None:
        """Give it an impulse at an arm from its centre, and a moment beside it."""
        about = _cross(arm, impulse) + (0.0 if moment is None else moment)
        self.state.velocity = self.state.velocity + impulse / self.what.shape.mass
        self.state.momentum = self.state.momentum + about
        self.spin = self.spin + self.inverse @ about

    def pose(self, dt: float, share: float) -> tuple[Floats, Floats]:
        """Return its centre and turn after so much of its way in a substep; it is lifted out of the ground."""
        assert self.fall
        centre = self.state.centre + share * (dt * self.state.velocity + self.apart[:3])
        turn = rotation(share * (dt * self.spin + self.apart[3:])) @ self.state.turn
        if self.fall.ground > -np.inf and share == 1 and centre[2] - self.radius < self.fall.ground:
            centre[2] = max(centre[2], self.fall.ground - float((self.what.seen @ turn[2]).min()))
        return centre, turn

    def watch(self, tick: float) -> None:
        """After a tick, note whether it has been slow for long, and is where it was when that began."""
        size, self.rested = 2 * self.radius, False
        if self.speed() > REST_SPEED * size:
            self.quiet = 0.0
            return
        if self.quiet == 0 or self.still is None:
            self.still = self.state.centre, self.state.turn
        self.quiet += tick
        if self.quiet >= REST_TIME:
            way, turn = (now - then for now, then in zip((self.state.centre, self.state.turn), self.still, strict=True))
            gone = float(np.linalg.norm(way) + np.linalg.norm(turn) * self.radius)
            self.quiet, self.rested = 0.0, gone <= ROUNDING * size


@dataclass(slots=True, kw_only=True, eq=False)
class Support:
    """A prop and the ground, a collider, or another prop, that may touch: kept until the next look.

    at, weights, normal, touch, friction, share, anchor: as in `Meetings`.
    surfaces: both.
    props: the awake ones; None where it goes as it is led.
    led: (3,) velocity between what is led [m/s].
    point, arms: (3,) where they meet [m], and from both centres.
    begin, least, back: of a substep, as in `touching.resolve`.
    give: 1 / mass along the normal, and at most square to it.
    push, drag: impulses along the normal and square to it [N s].
    """

    at: Ints
    weights: Floats
    normal: Floats
    touch: float
    friction: float
    share: float
    surfaces: tuple[int, int]
    anchor: Floats = field(default_factory=lambda: np.zeros(3))
    props: list[Prop | None] = field(default_factory=list)
    led: Floats = field(default_factory=lambda: np.zeros(3))
    point: Floats = field(default_factory=lambda: np.zeros(3))
    arms: list[Floats] = field(default_factory=list)
    begin: float = 0.0
    least: float = 0.0
    back: Floats = field(default_factory=lambda: np.zeros(3))
    give: tuple[float, float] = (0.0, 0.0)
    push: float = 0.0
    drag: Floats = field(default_factory=lambda: np.zeros(3))

    @property
    def impulse(self) -> Floats:
        return self.push * self.normal + self.drag

    def start(self, props: list[Prop | None], ends: tuple[Floats, Floats], dt: float) -> None:
        """Begin a substep.

        Args:
            ends: where the nearest points of both are, each (3,) [m].
        """
        self.props = props
        if not any(props):
            self.push, self.drag = 0.0, np.zeros(3)
            return
        skins = [0.0 if prop is None else prop.what.skin for prop in props]
        way = ends[0] - ends[1]
        # of the surfaces as they are seen
        self.point = ends[0] - (skins[0] / sum(skins) if sum(skins) > 0 else 0.0) * way
        self.arms = [np.zeros(3) if prop is None else self.point - prop.state.centre for prop in props]
        self.begin = float(way @ self.normal)
        self.least = min((self.touch - self.begin) / dt, 0.0)
        along = self._gives(self.normal)
        self.give = along, sum(self._gives(axis) for axis in np.eye(3)) - along
        self.back = BACK / dt * (way - self.begin * self.normal - self.anchor)

    def _gives(self, way: Floats) -> float:
        """Return what an impulse along a direction gives: 1 / mass."""
        give = 0.0
        for prop, arm in zip(self.props, self.arms, strict=True):
            if prop is not None:
                about = _cross(arm, way)
                give += 1 / prop.what.shape.mass + float(about @ prop.inverse @ about)
        return give

    def slip(self) -> Floats:
        """Return the velocity between the points of both (3,) [m/s]."""
        u = self.led.copy()
        for prop, arm, sign in zip(self.props, self.arms, (1, -1), strict=True):
            if prop is not None:
                u += sign * (prop.state.velocity + _cross(prop.spin, arm))
        return u

    def pass_on(self, impulse: Floats, moment: Floats | None = None) -> None:
        """Give both an impulse, and a moment."""
        for prop, arm, sign in zip(self.props, self.arms, (1, -1), strict=True):
            if prop is not None:
                prop.push(sign * impulse, arm, None if moment is None else sign * moment)

    def resolve(self) -> float:
        """Add so much that nothing goes nearer than it may, and slides no more than friction lets it; return that."""
        soft, before = self.give[0] * (1 / self.share - 1), self.push
        along = float(self.slip() @ self.normal)
        self.push = max(before + self.share / self.give[0] * (self.least - along - soft * before), 0.0)
        self.pass_on((self.push - before) * self.normal)
        u = self.slip()
        drag = self.drag - (u - (u @ self.normal) * self.normal + self.back) / self.give[1]
        size, most = float(np.linalg.norm(drag)), self.friction * self.push
        drag = drag * (most / size) if size > most else drag
        more, self.drag = drag - self.drag, drag
        self.pass_on(more)
        return abs(self.push - before) + float(np.linalg.norm(more))

    def resist_turning(self) -> None:
        """Resist rolling: a moment above a small arm times the load turns one against the other."""
        spin, size, give = np.zeros(3), 0.0, 0.0
        for prop, sign in zip(self.props, (1, -1), strict=True):
            if prop is not None:
                spin, size = spin + sign * prop.spin, max(size, 2 * prop.radius)
        square = float(spin @ spin)
        if square > 0 and self.push > 0:
            give = sum(float(spin @ prop.inverse @ spin) for prop in self.props if prop is not None)
            self.pass_on(np.zeros(3), -min(square / give, ROLL_ARM * size * self.push / square**0.5) * spin)

    def part(self, dt: float) -> None:
        """Bring apart what would be nearer than it touches, and let the anchor follow where it slides."""
        gap = self.begin + dt * float(self.slip() @ self.normal)
        for prop, arm, sign in zip(self.props, self.arms, (1, -1), strict=True):
            if prop is not None:
                gap += sign * float((prop.apart[:3] + _cross(prop.apart[3:], arm)) @ self.normal)
        if self.push > 0 and gap < self.touch:
            by = self.share * BACK * (self.touch - gap) / self.give[0]
            for prop, arm, sign in zip(self.props, self.arms, (1, -1), strict=True):
                if prop is not None:
                    turn = prop.inverse @ _cross(arm, self.normal)
                    prop.apart += sign * by * np.concatenate([self.normal / prop.what.shape.mass, turn])
        if not self.push > 0 or np.linalg.norm(self.drag) >= self.friction * self.push * (1 - ROUNDING):
            self.anchor = self.anchor + dt / BACK * self.back


def resolve_supports(supports: list[Support], dt: float) -> None:
    """Let props pass on to each other, and to what does not give, what a substep needs."""
    awake = [support for support in supports if any(support.props)]
    for support in awake:
        if support.push > 0:
            support.pass_on(support.impulse)
    for _ in range(SWEEPS):
        changed = sum(support.resolve() for support in awake)
        if not changed > EXACT * sum(support.push for support in awake):
            break
    for support in awake:
        support.resist_turning()
    for support in awake:
        support.part(dt)


def ground_supports(prop: Prop, surface: int, friction: float, dt: float) -> list[Support]:
    """Return what of a prop may touch the ground in a substep."""
    assert prop.fall
    turn, centre, ground = prop.state.turn, prop.state.centre, prop.fall.ground
    near = HELD * prop.radius + dt * prop.speed()
    if not centre[2] - prop.radius < ground + near:
        return []
    arms = prop.what.seen @ turn.T
    lowest = int(arms[:, 2].argmin())
    if not arms[lowest, 2] + centre[2] < ground + near:
        return []
    low = np.flatnonzero(arms[:, 2] < arms[lowest, 2] + near)
    corners = [lowest, *low[(arms[low, :2] @ SIDES.T).argmax(axis=0)].tolist()]
    found = []
    for vertex in dict.fromkeys(corners):
        end = arms[vertex] + centre
        made = Support(
            at=np.zeros(0, np.int64), weights=np.zeros(0), normal=np.array([0.0, 0.0, 1.0]), touch=0.0,
            friction=friction, share=1.0, surfaces=(surface, NOBODY),
        )  # fmt: skip
        made.start([prop, None], (end, np.array([end[0], end[1], ground])), dt)
        found.append(made)
    return found


def _cross(a: Floats, b: Floats) -> Floats:
    """Return the product of two vectors: far faster than numpy's for so few."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])
