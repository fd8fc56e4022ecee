"""What stands between a computed force and a person's hand. Nothing here may be weakened.

Small state machines on an injected clock; every force of a fingertip passes `Guard.output`, and there is no other way.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from enum import Enum

from ..vectors import ZERO, Vector, along, capped, dot, is_finite, length, scaled
from .passivity import Passivity
from .servo_notes import NOT_ARMED

HARD_CEILING = 20.0  # [N] whatever limits a device reports
QUIET_FORCE, QUIET_TIME = 0.2, 0.050  # [N], [s] arming waits for less force than this for so long: nothing may kick
ASK_TIME = 1.2  # [s] the device itself waits for the quiet for 1 s, then refuses
RAMP_TIME = 0.5  # [s] from nothing to the whole force
RAMP_DAMPING = 3.0  # [N s/m] while it ramps
SLEW = 1000.0  # [N/s] 1 N a millisecond
TOP_SPEED = 1.5  # [m/s] no hand exploring an object is faster; a motor running away is
RMS_TIME = 10.0  # [s] window of the root mean square force: the heat of the motors
STATE_GAP, STATE_LOST = 0.005, 0.100  # [s] without a STATE: no force; the device counts as lost
BAD_NUMBERS, BAD_TIME = 3, 0.100  # so many NaN or inf within so long [s] disarm
# [s] for how long the dead-man key counts as held after it was last seen down: force fades within 0.2 s of a standstill
# anyway, and a key held through one of that length, renewed every 0.05 s, need not be armed again
LEASE = 0.3
SPEED_TIME = 0.005  # [s] time constant of the speed: one converter bit a tick is already 0.1 m/s


class Arming(Enum):
    """How far the arming is."""

    OFF = 0
    WAITING = 1  # until no force would act on the hand
    ASKED = 2  # the device has been asked to arm
    RAMP = 3
    ON = 4


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of one fingertip: peak and continuous (10 s rms) force [N]."""

    peak: float
    continuous: float


@dataclass(slots=True)
class Switch:
    """The arming of the device. After a disarm, whatever its reason, only a new request arms.

    arming: how far it is.
    reason: why it is off, for the artist.
    since: when this state, or the quiet in it, began [s].
    """

    arming: Arming = Arming.OFF
    reason: str = ""
    since: float = math.inf

    def arm(self) -> None:
        """Request force."""
        if self.arming is Arming.OFF:
            self._go(Arming.WAITING)
            self.reason = ""

    def disarm(self, reason: str) -> None:
        """Take all force away, at once."""
        if self.arming is not Arming.OFF:
            self._go(Arming.OFF)
            self.reason = reason

    def gain(self, wanted: float, now: float, *, held: bool, device_on: bool) -> float:
        """Return the share of the force that may act.

        Args:
            wanted: the largest force that would act on a fingertip [N].
            now: [s].
            held: the dead-man switch is held.
            device_on: the device itself is armed.
        """
        if not held and self.arming is not Arming.OFF:
            self._go(Arming.WAITING)
        match self.arming:
            case Arming.WAITING:
                self.since = min(self.since, now) if held and wanted < QUIET_FORCE else math.inf
                if now - self.since >= QUIET_TIME:
                    self._go(Arming.RAMP if device_on else Arming.ASKED, now)
            case Arming.ASKED if device_on:
                self._go(Arming.RAMP, now)
            case Arming.ASKED if now - self.since > ASK_TIME:
                self.disarm(NOT_ARMED)
            case Arming.RAMP | Arming.ON if not device_on:  # it brakes, and its ramp begins anew
                self._go(Arming.RAMP, now)
        if self.arming is Arming.RAMP and now - self.since >= RAMP_TIME:
            self._go(Arming.ON, now)
        if self.arming is Arming.RAMP:
            return (now - self.since) / RAMP_TIME
        return 1.0 if self.arming is Arming.ON else 0.0

    def _go(self, arming: Arming, since: float = math.inf) -> None:
        self.arming, self.since = arming, since


@dataclass(slots=True)
class BadNumbers:
    """A count of the NaN and inf that would have been forces."""

    times: deque[float] = field(default_factory=lambda: deque(maxlen=BAD_NUMBERS))

    def count(self, now: float) -> None:
        """Count one more."""
        self.times.append(now)

    def too_many(self) -> bool:
        """Tell, once, whether there were too many."""
        many = len(self.times) == BAD_NUMBERS and self.times[-1] - self.times[0] <= BAD_TIME
        if many:
            self.times.clear()
        return many


@dataclass(slots=True)
class Velocity:
    """The velocity of a fingertip [m/s], filtered because of the steps of its converter."""

    at: Vector | None = None
    since: float = 0.0
    speed: Vector = ZERO

    def move(self, x: Vector, now: float) -> None:
        """Take a position [m]."""
        before, dt = self.at, now - self.since
        self.at, self.since = x, now
        if before and dt > 0:
            speed = scaled(along(x, before, -1.0), 1 / dt)
            self.speed = along(self.speed, along(speed, self.speed, -1.0), dt / (SPEED_TIME + dt))

    def stop(self) -> None:
        """Forget the last position: the next one is not compared with it."""
        self.at, self.speed = None, ZERO


@dataclass(slots=True)
class Guard:
    """The limits of one fingertip, with the state they need.

    limits: peak and continuous force.
    motion: its velocity.
    passivity: its energy.
    sent: the force that acts now [N].
    square: 10 s mean of its square [N2].
    full: it had to be limited.
    """

    limits: Limits
    motion: Velocity = field(default_factory=Velocity)
    passivity: Passivity = field(default_factory=Passivity)
    sent: Vector = ZERO
    square: float = 0.0
    full: bool = False

    def move(self, x: Vector, now: float, acted: Vector | None = None, left: float = 1.0) -> None:
        """Take the fingertip's position [m], and the force that acted on the way to it.

        Args:
            x: position [m].
            now: [s].
            acted: the force [N], None for the one sent.
            left: share of it at the end of the way, where the device lets go of an old command; what the hand gave is
                counted with that share, what it got with the whole.
        """
        dt = now - self.motion.since if self.motion.at else 0.0
        acted = self.sent if acted is None else acted
        if left < 1 and self.motion.at and dot(acted, along(x, self.motion.at, -1.0)) < 0:
            acted = scaled(acted, left)
        self.motion.move(x, now)
        self.passivity.observe(acted, x, now)
        self.square += (dot(self.sent, self.sent) - self.square) * min(max(dt, 0.0) / RMS_TIME, 1.0)

    def skip(self) -> None:
        """Miss a position: the next one is not compared with the last."""
        self.motion.stop()
        self.passivity.skip()

    def output(self, wanted: Vector, gain: float, dt: float) -> Vector:
        """Return the force [N] that may act where another is wanted; where that is not a number, none."""
        if not is_finite(wanted):
            return self.zero()
        left = self.passivity.want(wanted, dt)
        if gain <= 0:
            return self.zero()
        speed = self.motion.speed
        force = along(scaled(left, gain), speed, -RAMP_DAMPING * (1 - gain))
        force = self.passivity.damp(force, speed, dt)
        force = self.passivity.afford(force, speed)
        most = min(self.limits.peak, HARD_CEILING)
        if self.square >= self.limits.continuous**2:
            most = min(most, self.limits.continuous)
        self.full = length(force) > most
        force = capped(force, most)
        self.sent = along(self.sent, capped(along(force, self.sent, -1.0), SLEW * max(dt, 0.0)), 1.0)
        return self.sent

    def zero(self) -> Vector:
        """Take all force away, at once."""
        self.sent, self.full = ZERO, False
        return ZERO

    @property
    def runs_away(self) -> bool:
        """Tell whether the fingertip is faster than any hand."""
        return not math.sqrt(dot(self.motion.speed, self.motion.speed)) <= TOP_SPEED
