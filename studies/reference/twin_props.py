"""The props of a scene that numpy steps: what they may stand on, how far they may go, and what soft bodies answer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from core.base import Floats, Ints
from core.native.scene import Collider, ColliderMotion, Fall, Way

from .falling import NOBODY, Prop, Support, ground_supports, resolve_supports
from .proximity import Surfaces
from .touching import Meetings


class Props:
    """The props among the colliders of a scene.

    of: of each surface, None where it does not fall.
    supports: what they may stand on before the next look, and
    standing: in a substep, with the ground.
    """

    def __init__(self, bodies: int, colliders: Sequence[Collider]) -> None:
        self.of: list[Prop | None] = [None] * bodies
        self.of += [Prop(c.falling) if c.falling else None for c in colliders]
        self.skins = np.array([prop.what.skin if prop else 0.0 for prop in self.of])
        self._frictions = [0.0] * bodies + [c.friction for c in colliders]
        self.supports: list[Support] = []
        self.standing: list[Support] = []
        self._left: dict[int, tuple[Floats, ...]] = {}  # how they were when the last call ended

    @property
    def awake(self) -> list[tuple[int, Prop]]:
        return [(i, prop) for i, prop in enumerate(self.of) if prop and not prop.asleep]

    def take(self, ways: Sequence[Way], here: list[Floats], rates: list[Floats]) -> bool:
        """Take how props move; return whether one was put elsewhere."""
        moved, bodies = False, len(self.of) - len(ways)
        for i, way in enumerate(ways):
            prop = self.of[bodies + i]
            if not prop or not isinstance(way, Fall):
                continue
            state, prop.fall = _copy(way), way
            left = self._left.get(bodies + i)
            same = [left is not None and np.array_equal(a, b) for a, b in zip(state, left or state, strict=True)]
            if all(same):
                continue
            prop.asleep, prop.quiet = False, 0.0
            if not all(same[:4]):
                here[i] = np.ascontiguousarray((prop.what.shape.arms @ state[1].T + state[0]).T)
                prop.answer, prop.spin, moved = np.zeros(6), np.zeros(3), True
                rates[i][:] = 0
        return moved

    def leave(self) -> None:
        """Note how props are as a call ends."""
        self._left.update({i: _copy(prop.fall) for i, prop in enumerate(self.of) if prop and prop.fall})

    def wake(self, put_elsewhere: int) -> None:
        """Wake all, for they may stand on what was put elsewhere."""
        for prop in self.of:
            if prop:
                prop.asleep, prop.quiet = False, 0.0
        self._left.pop(put_elsewhere, None)

    def note(self, met: Meetings, s: Surfaces) -> None:
        """Take from a look which pairs may touch."""
        self.supports = [
            Support(
                at=met.at[k], weights=met.weights[k], normal=met.normal[k], touch=float(met.touch[k]),
                friction=float(met.friction[k]), share=float(met.share[k]),
                surfaces=(int(s.of_vertex[met.at[k, 0]]), int(s.of_vertex[met.at[k, 3]])),
            )
            for k in range(len(met.gap))
        ]  # fmt: skip

    def begin(self, x: Floats, dt: float) -> None:
        """Begin a substep of all that are awake, at positions x (n, 3) [m]."""
        awake = dict(self.awake)
        for prop in awake.values():
            prop.begin(dt)
        for support in self.supports:
            ahead = support.weights > 0
            ends = (
                support.weights[ahead] @ x[support.at[ahead]], -support.weights[~ahead] @ x[support.at[~ahead]]
            )  # fmt: skip
            support.start([awake.get(i) for i in support.surfaces], ends, dt)
        ground = [
            each for i, prop in awake.items() if prop.fall and prop.fall.ground > -np.inf
            for each in ground_supports(prop, i, self._frictions[i], dt)
        ]  # fmt: skip
        self.standing = [*self.supports, *ground]

    def resolve(self, velocities: Floats, dt: float, impulses: Floats) -> int:
        """Let props pass on to each other what a substep needs; return how many pairs touch.

        Args:
            velocities: (n, 3) of what is led [m/s].
            impulses: (k, 6) that each surface got, and their moments: they are added to.
        """
        for support in self.supports:
            led = [sign * (prop is None) for prop, sign in zip(support.props, (1, -1), strict=True)]
            way = np.abs(support.weights) * np.where(support.weights > 0, led[0], led[1])
            support.led = way @ velocities[support.at]
        resolve_supports(self.standing, dt)
        touching = [support for support in self.standing if support.push > 0]
        for support in touching:
            given = np.concatenate([support.impulse, np.cross(support.point, support.impulse)])
            for surface, sign in zip(support.surfaces, (1, -1), strict=True):
                if surface != NOBODY:
                    impulses[surface] += sign * given
        return len(touching)

    def answer(self, sides: Ints, point: Floats, passed: Floats) -> None:
        """Note what soft bodies answered in a substep: impulses passed (m, 3) [N s] at points (m, 3) [m]."""
        for i, prop in self.awake:
            prop.answer = np.zeros(6)
            for side, sign in ((0, 1), (1, -1)):
                mine = sides[:, side] == i
                moments = np.cross(point[mine] - prop.state.centre, passed[mine])
                prop.answer += sign * np.concatenate([passed[mine].sum(axis=0), moments.sum(axis=0)])


def leave(prop: Prop, share: float, dt: float) -> None:
    """Leave a prop where a share of its way ends; where that was not all, it has lost as much of its speed."""
    if share > 0:
        prop.state.centre, prop.state.turn = prop.pose(dt, share)
    if share < 1:
        prop.state.velocity, prop.state.momentum = share * prop.state.velocity, share * prop.state.momentum
        prop.spin = share * prop.spin


def _copy(fall: Fall | Way) -> tuple[Floats, ...]:
    assert isinstance(fall, Fall) and not isinstance(fall, ColliderMotion)
    s = fall.state
    return s.centre, s.turn, s.velocity, s.momentum, np.array(fall.gravity, np.float64), np.array(fall.ground)
