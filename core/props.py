"""Props: rigid meshes with a mass that fall on soft bodies, sink in by their weight, and rest or roll off.

A prop is a collider that goes where it falls. Each tick it is led on by its own velocity, and then given what the
bodies answered: the reaction of one tick acts in the next. That is stable while a prop is heavier than the skin it
moves with it, so a lighter one moves as if it were that heavy, though it presses with its own weight.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .base import Floats, Ints
from .session import Session
from .solver import rigid
from .solver.rigid import RigidShape, RigidState
from .solver.scene import Collider
from .world import Meeting, World

LEAST_SHARE = 0.1  # of the lightest body's mass: what a prop has at least when it moves
SETTLING = 0.05  # of its critical damping against the softest body that it presses: it comes to rest
HELD = 1e-9  # [m] a prop that is farther behind its way than this was held back


@dataclass(frozen=True, slots=True, kw_only=True)
class Prop:
    """A rigid mesh with a mass.

    positions: (m, 3) where it is at the start [m].
    triangles: (t, 3).
    mass: [kg].
    friction: coefficient.
    name: for messages.
    """

    positions: Floats
    triangles: Ints
    mass: float
    friction: float = 0.5
    name: str = "Prop"


class PropWorld:
    """Step sessions with props and colliders that are led.

    Args:
        sessions: as for a World.
        props: that fall.
        colliders: that are led, after them.
        gravity: (3,) [m/s2].
        itself, names: as for a World; names of the bodies and the colliders.

    Raises:
        DimpleError: a prop without mass or faces, or something passes through something else.
    """

    def __init__(
        self,
        sessions: Sequence[Session],
        props: Sequence[Prop],
        *,
        colliders: Sequence[Collider] = (),
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        itself: Sequence[bool] | None = None,
        names: Sequence[str] = (),
    ) -> None:
        self.gravity, self.props = np.array(gravity, np.float64), list(props)
        self.shapes = [rigid.rigid_shape(prop.positions, prop.triangles, prop.mass) for prop in self.props]
        self._moving = [_heavier(shape, sessions) for shape in self.shapes]
        self.states = [rigid.at_rest(shape) for shape in self.shapes]
        self._damping = [_damping(shape.mass, sessions) for shape in self._moving]
        led = [Collider(np.ascontiguousarray(p.positions.T, np.float64), p.triangles, p.friction) for p in self.props]
        bodies, rest = list(names[: len(sessions)]), list(names[len(sessions) :])
        bodies += [f"Body {i + 1}" for i in range(len(bodies), len(sessions))]
        self.world = World(
            sessions, [*led, *colliders], itself=itself, names=[*bodies, *(prop.name for prop in self.props), *rest]
        )
        self._left = 0.0

    def step(self, dt: float, *, budget: float | None = None) -> Meeting:
        """Advance everything by dt [s] in whole ticks; what is left over is carried to the next call.

        Args:
            budget: stop after this much wall time [s].
        """
        started, tick = time.perf_counter(), self.world.sessions[0].tick
        self._left += dt
        while self._left > tick * (1 - 1e-6):
            self._left -= tick
            self._tick(tick)
            if budget is not None and time.perf_counter() - started > budget:
                self._left = 0.0
        return self.world.meeting

    def positions(self, index: int) -> Floats:
        """Return where the vertices of a prop (m, 3) [m] are."""
        return rigid.positions(self.shapes[index], self.states[index])

    def reset(self) -> None:
        """Put everything back to where it was at the start."""
        self.world.reset()
        self.states, self._left = [rigid.at_rest(shape) for shape in self.shapes], 0.0

    def _tick(self, tick: float) -> None:
        for moving, state in zip(self._moving, self.states, strict=True):
            rigid.move(moving, state, tick)
        self.world.set_colliders([self.positions(i) for i in range(len(self.props))])
        meeting = self.world.step(tick)
        first = len(self.world.sessions)
        for i, (moving, state) in enumerate(zip(self._moving, self.states, strict=True)):
            self._wait(i, state, tick)
            force, moment = meeting.forces[first + i], meeting.moments[first + i]
            # light ones press with their own weight, whatever they move as
            weight = self.props[i].mass * self.gravity
            about = moment - np.cross(state.centre, force)
            rigid.push(state, moving.mass, tick * (force + weight), tick * about)
            if not force.any():
                continue
            share = 1 / (1 + tick * self._damping[i] / moving.mass)
            state.velocity, state.momentum = share * state.velocity, share * state.momentum

    def _wait(self, index: int, state: RigidState, tick: float) -> None:
        """Let a prop that was held back be where it is, at the speed it got there."""
        wanted, there = self.positions(index), self.world.collider(index)
        if np.abs(there - wanted).max() < HELD:
            return
        behind = (there - wanted).mean(axis=0)
        state.centre = state.centre + behind
        state.velocity = state.velocity + behind / tick


def _heavier(shape: RigidShape, sessions: Sequence[Session]) -> RigidShape:
    """Return a rigid body that is heavy enough to be moved tick by tick."""
    least = LEAST_SHARE * min(float(session.model.mass.sum()) for session in sessions)
    if shape.mass >= least:
        return shape
    return replace(shape, mass=least, inertia=least / shape.mass * shape.inertia)


def _damping(mass: float, sessions: Sequence[Session]) -> float:
    softest = min(min(m.K1, m.K2) for session in sessions for m in session.model.materials)
    return SETTLING * 2 * math.sqrt(softest * mass)
