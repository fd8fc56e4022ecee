"""The energy that a fingertip's force takes from a hand and gives it: it may not give more.

Nothing here may be weakened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..vectors import ZERO, Vector, along, dot, scaled
from . import limits
from .spec import Spec
from .wire import ARMED, FINGERS, MODE, RAMP, DeviceState

Forces = tuple[Vector, ...]


def _is_far(x: Vector, before: Vector) -> bool:
    way = along(x, before, -1.0)
    return dot(way, way) > limits.GRAIN**2


@dataclass(slots=True)
class Passivity:
    """The energy that a fingertip's force took from the hand; damps where it gave back more than it took.

    A piece of the path is counted when it is longer than the noise of the converters: the force follows their noise,
    and tick by tick that would look like energy (K sigma^2 each).

    stored: energy taken less energy given, of this touch [J].
    least: the lowest it ever was [J].
    idle_since: since when no force acts [s].
    at: the last position [m].
    begin: where the piece under way began [m].
    total: the sum of the forces along it [N].
    count: their number.
    share: of the force that is left, less once the touch gave back too much.
    floor: stored energy below which it falls [J].
    owed: stored energy above which it comes back: the hand has paid by pressing on [J].
    unwanted: for how long no force has been wanted [s].

    Source: Hannaford and Ryu, time-domain passivity control; the force that yields is ours.
    """

    stored: float = 0.0
    least: float = 0.0
    idle_since: float | None = None
    at: Vector | None = None
    begin: Vector | None = None
    total: Vector = ZERO
    count: int = 0
    share: float = 1.0
    floor: float = -limits.ALLOWED
    owed: float = -limits.ALLOWED
    unwanted: float = 0.0

    def observe(self, force: Vector, x: Vector, now: float) -> None:
        """Take the force [N] that acted until the fingertip came to x [m]."""
        if self.at and self.count and _is_far(x, self.at):  # a long step is a piece of its own, with its own force
            self._count(self.at)
        self.total, self.count, self.at = along(self.total, force, 1.0), self.count + 1, x
        if self.begin is None or _is_far(x, self.begin):
            self._count(x)
        if force != ZERO:
            self.idle_since = None
        elif self.idle_since is None:
            self.idle_since = now
        elif now - self.idle_since > limits.QUIET_TIME:
            self.stored = min(self.stored, 0.0)  # what was dissipated pays for nothing later

    def _count(self, x: Vector) -> None:
        """Count the piece under way, which ends at x [m]."""
        self.stored -= dot(self.total, along(x, self.begin or x, -1.0)) / self.count
        self.least = min(self.least, self.stored)
        if self.stored < self.floor:
            self.share *= math.exp((self.stored - self.floor) / limits.YIELD_ENERGY)
            self.floor = self.stored
        self.begin, self.total, self.count = x, ZERO, 0

    def skip(self) -> None:
        """Drop the piece under way: a sensor failed."""
        self.at, self.begin, self.total, self.count = None, None, ZERO, 0

    def lose(self) -> None:
        """Note that the device let go: a fingertip that sank in is pushed out with no more than the hand gave."""
        self.floor = min(limits.SPARE, self.stored - limits.GRAIN_ENERGY)
        self.owed = max(self.owed, self.floor)

    def want(self, force: Vector, dt: float) -> Vector:
        """Return what is left of a force [N] wanted for a time [s]; wanted none for a while, the touch is over.

        What was taken away comes back slowly, as a force that is armed does; at once it would push the hand.
        """
        self.unwanted = 0.0 if force != ZERO else self.unwanted + dt
        if self.unwanted > limits.QUIET_TIME:
            self.share, self.floor = 1.0, min(self.stored, 0.0) - limits.ALLOWED
            self.owed = self.floor
        elif self.share < 1 and self.stored > self.owed:
            self.share, self.floor = min(self.share + dt / limits.RAMP_TIME, 1.0), self.owed
        return scaled(force, self.share)

    def afford(self, force: Vector, speed: Vector) -> Vector:
        """Return the force [N], less where at a speed [m/s] it would give more than is left before that is known."""
        given, left = limits.KNOWN_LATE * dot(force, speed), max(self.stored - self.floor, 0.0)
        return scaled(force, left / given) if given > left else force

    def damp(self, force: Vector, speed: Vector, dt: float) -> Vector:
        """Return the force [N], damped so that what was given too much is taken back."""
        taken = dot(speed, speed) * dt  # [J] by a damper of 1 N s/m; of a fingertip at rest it underflows
        if self.stored >= 0 or force == ZERO or taken <= 0:
            return force
        return along(force, speed, -min(-self.stored / taken, limits.MOST_DAMPING))


@dataclass(slots=True)
class SentForces:
    """The forces of the last commands, and which of them acts: that of the one which the device acknowledged.

    The device ramps its force by itself where its dead-man switch was released, be it by a command after a silence.

    sent: by the sequence numbers of their commands [N]; of those that release the dead-man switch none.
    since: when the device first acknowledged the command that acts, on its clock [s].
    ramp_since: when its ramp began, if it ramps, on its clock [s].
    """

    sent: dict[int, Forces] = field(default_factory=dict)
    since: float = 0.0
    ramp_since: float = 0.0

    def send(self, seq: int, forces: Forces | None) -> None:
        """Take the forces [N] of a command that is sent, None where it releases the dead-man switch."""
        self.sent.pop(seq - 0x100 & 0xFFFF, None)  # older than a device can acknowledge
        if forces:
            self.sent[seq] = forces

    def restarts_ramp(self, before: DeviceState | None, state: DeviceState) -> bool:
        """Tell whether the device's ramp began again after the STATE before."""
        was_armed = before is not None and before.status & MODE == ARMED
        return state.status & MODE == RAMP and (was_armed or state.ack not in self.sent)

    def between(self, spec: Spec, before: DeviceState | None, state: DeviceState, now: float) -> tuple[Forces, float]:
        """Return the forces [N] that acted from a STATE to the next, and the share of them that is left at its end.

        now: of the second STATE, on the device's clock [s].
        """
        none = (ZERO,) * FINGERS
        acted = self.sent.get(before.ack, none) if before else none
        if before and before.status & MODE == RAMP:
            gain = min((now - self.ramp_since) / limits.RAMP_TIME, 1.0)
            acted = tuple([scaled(force, gain) for force in acted])
        left = spec.left(now - self.since)
        if before is None or state.ack != before.ack:
            self.since = now
        if state.status & MODE != RAMP or state.ack not in self.sent:
            self.ramp_since = now
        return acted, left
