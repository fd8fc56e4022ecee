"""The energy that a fingertip's force takes from a hand and gives back: it may not give more than it took.

Nothing here may be weakened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..vectors import ZERO, Vector, along, dot, scaled
from . import limits
from .spec import Spec
from .wire import FINGERS, MODE, RAMP, DeviceState

Forces = tuple[Vector, ...]


@dataclass(slots=True)
class Passivity:
    """The energy that a fingertip's force took from the hand; the force is damped if it gave back more.

    stored: energy taken minus energy given in this touch [J].
    least: minimum of `stored` so far [J].
    left: share of a force that device and simulation let act; where that falls, a fingertip sinks in.
    share: of a wanted force that is left, less than 1 once the touch gave back too much, or after `left` was.
    floor: stored energy below which the share falls [J].
    owed: stored energy above which the share recovers: the hand has paid by pressing on [J].
    unwanted: how long no force has been wanted [s].

    Source: Hannaford and Ryu, time-domain passivity control; the yielding force is our addition.
    """

    stored: float = 0.0
    least: float = 0.0
    left: float = 1.0
    share: float = 1.0
    floor: float = -limits.ALLOWED
    owed: float = -limits.ALLOWED
    unwanted: float = 0.0

    def observe(self, force: Vector, way: Vector) -> None:
        """Take the force [N] that acted on a way of the fingertip [m]."""
        self.stored -= dot(force, way)
        self.least = min(self.least, self.stored)
        if self.stored < self.floor:
            self.share *= math.exp((self.stored - self.floor) / limits.YIELD_ENERGY)
            self.floor = self.stored

    def want(self, force: Vector, dt: float, held: float = math.inf) -> Vector:
        """Return what is left of a force [N] wanted for a time [s], where the dent holds an energy [J].

        The touch ends a while after the force.

        A reduced force recovers as slowly as the force after arming; a sudden recovery would push the hand. Energy that
        was dissipated, such as by friction, is no credit: neither for a fingertip that sinks in nor for the next touch.
        """
        self.unwanted = 0.0 if force != ZERO else self.unwanted + dt
        if self.left < 1:  # a fingertip that sinks in gets back no more than the hand gave to what acts like a spring
            self.stored = min(self.stored, held)
            self.owed = max(self.owed, min(self.stored - limits.ALLOWED, limits.ALLOWED))
            self.floor = max(self.floor, self.owed)
        if self.unwanted > limits.QUIET_TIME:
            self.share, self.stored = 1.0, min(self.stored, 0.0)
            self.owed = self.floor = self.stored - limits.ALLOWED
        elif self.share < 1 and self.stored > self.owed:
            self.share, self.floor = min(self.share + dt / limits.RAMP_TIME, 1.0), self.owed
        self.share = min(self.share, self.left)
        return scaled(force, self.share)

    def damp(self, force: Vector, speed: Vector, dt: float) -> Vector:
        """Return the force [N], damped so that excess energy is taken back."""
        taken = dot(speed, speed) * dt  # [J] that a damper of 1 N s/m takes; underflows for a fingertip at rest
        if self.stored >= 0 or force == ZERO or taken <= 0:
            return force
        return along(force, speed, -min(-self.stored / taken, limits.MOST_DAMPING))


@dataclass(slots=True)
class SentForces:
    """The forces of the recent commands; the one that acts belongs to the command that the device acknowledged.

    The device ramps its force by itself after its dead-man switch was released, even by the command sent in a silence.

    delay: mean time from a position to the force that answers it [s].
    sent: forces by sequence number of their command [N], None if it releases the dead-man switch; and when the STATE
        that it answers was sent, on the device's clock [us].
    since: when the device first acknowledged the acting command, on its clock [s].
    ramp_since: when its ramp began, if it is ramping, on its clock [s].
    """

    delay: float
    sent: dict[int, tuple[Forces | None, int]] = field(default_factory=dict)
    since: float = 0.0
    ramp_since: float = 0.0

    def send(self, seq: int, forces: Forces | None, t_us: int) -> None:
        """Take a command that is sent, see `sent`."""
        self.sent.pop(seq - 0x100 & 0xFFFF, None)  # older than a device can acknowledge
        self.sent[seq] = forces, t_us

    def measure(self, state: DeviceState, tick: float) -> None:
        """Measure the delay: the acknowledged force acts from this tick [s] on, and answers an earlier STATE."""
        if state.ack in self.sent:
            delay = (state.t_us - self.sent[state.ack][1] & 0xFFFFFFFF) * 1e-6
            self.delay += (delay - self.delay) * min(tick / limits.DELAY_TIME, 1.0)

    def _forces(self, state: DeviceState) -> Forces | None:
        return self.sent.get(state.ack, (None, 0))[0]

    def between(self, spec: Spec, before: DeviceState | None, state: DeviceState, now: float) -> tuple[Forces, float]:
        """Return the forces [N] that acted between two STATEs, and the share of them that is left at the second.

        now: time of the second STATE, on the device's clock [s].
        """
        acted = before and self._forces(before) or (ZERO,) * FINGERS
        if before and before.status & MODE == RAMP:
            gain = min((now - self.ramp_since) / limits.RAMP_TIME, 1.0)
            acted = tuple([scaled(force, gain) for force in acted])
        left = spec.left(now - self.since)
        if before is None or state.ack != before.ack:
            self.since = now
        if state.status & MODE != RAMP or self._forces(state) is None:
            self.ramp_since = now
        return acted, left
