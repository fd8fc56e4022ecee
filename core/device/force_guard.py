"""The safety layer between a computed force and a person's hand. Nothing here may be weakened.

Small state machines that are given the time; every force of a fingertip passes `Guard.output`, without exception.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

from ..vectors import ZERO, Vector, along, capped, dot, is_finite, length, scaled
from . import limits
from .notes import NOT_ARMED
from .passivity import Passivity


class Arming(Enum):
    """The stages of arming."""

    OFF = 0
    WAITING = 1  # until the force that would act on the hand is small
    ASKED = 2  # the device has been asked to arm
    RAMP = 3
    ON = 4


@dataclass(slots=True)
class Switch:
    """The arming of the device. After a disarm, whatever its reason, only a new request arms.

    arming: its stage.
    reason: why it is off, for the artist.
    since: when this stage, or the quiet in it, began [s].
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
        """Remove all force at once."""
        if self.arming is not Arming.OFF:
            self._go(Arming.OFF)
            self.reason = reason

    def gain(self, wanted: float, now: float, *, held: bool, device_on: bool) -> float:
        """Return the share of the force that may act.

        Args:
            wanted: the largest force that would act on a fingertip [N].
            now: time [s].
            held: the dead-man switch is held.
            device_on: the device itself is armed.
        """
        if not held and self.arming is not Arming.OFF:
            self._go(Arming.WAITING)
        match self.arming:
            case Arming.WAITING:
                self.since = min(self.since, now) if held and wanted < limits.QUIET_FORCE else math.inf
                if now - self.since >= limits.QUIET_TIME:
                    self._go(Arming.RAMP if device_on else Arming.ASKED, now)
            case Arming.ASKED if device_on:
                self._go(Arming.RAMP, now)
            case Arming.ASKED if now - self.since > limits.REFUSAL_TIME:
                self.disarm(NOT_ARMED)
            case Arming.RAMP | Arming.ON if not device_on:  # it is braking, and its ramp will start again
                self._go(Arming.RAMP, now)
        if self.arming is Arming.RAMP and now - self.since >= limits.RAMP_TIME:
            self._go(Arming.ON, now)
        if self.arming is Arming.RAMP:
            return (now - self.since) / limits.RAMP_TIME
        return 1.0 if self.arming is Arming.ON else 0.0

    def _go(self, arming: Arming, since: float = math.inf) -> None:
        self.arming, self.since = arming, since


@dataclass(slots=True)
class Guard:
    """The limits of one fingertip, with the state they need.

    peak, continuous: largest force, momentary and sustained (10 s rms) [N].
    at: last position [m], None after one that is not trusted.
    since: when it was taken [s].
    speed: velocity of the fingertip [m/s], low-pass filtered against the quantization of its converter.
    passivity: energy balance of its force.
    sent: force that acts now [N].
    square: 10 s mean of its square [N2].
    full: the force had to be limited, or yields because it gave back more energy than it took.
    """

    peak: float
    continuous: float
    at: Vector | None = None
    since: float = 0.0
    speed: Vector = ZERO
    passivity: Passivity = field(default_factory=Passivity)
    sent: Vector = ZERO
    square: float = 0.0
    full: bool = False

    def move(self, x: Vector, now: float, acted: Vector | None = None, left: float = 1.0) -> None:
        """Take the fingertip's position [m], and the force that acted on the way to it.

        Args:
            x: position [m].
            now: time [s].
            acted: the force [N], None for the one sent.
            left: share of it at the end of the way, if the device lets go of an old command; energy that the hand gave
                is counted with that share of the force, energy that it got with the whole.
        """
        dt = max(now - self.since, 0.0) if self.at else 0.0
        way = along(x, self.at or x, -1.0)
        acted = self.sent if acted is None else acted
        self.passivity.observe(scaled(acted, left) if dot(acted, way) < 0 else acted, way)
        if dt > 0:
            self.speed = along(scaled(way, 1 / (limits.STATE_GAP + dt)), self.speed,
                               limits.STATE_GAP / (limits.STATE_GAP + dt))  # fmt: skip
        self.at, self.since = x, now
        self.square += (dot(self.sent, self.sent) - self.square) * min(dt / limits.RMS_TIME, 1.0)

    def skip(self) -> None:
        """Skip a position: the next one is not compared with the last."""
        self.at, self.speed = None, ZERO

    def output(self, wanted: Vector, gain: float, dt: float, held: float = math.inf) -> Vector:
        """Return the force [N] that may act for one wanted over a dent with an energy [J]; none if it is no number."""
        if not is_finite(wanted):
            return self.zero()
        left = self.passivity.want(wanted, dt, held)
        if gain <= 0:
            return self.zero()
        force = along(scaled(left, gain), self.speed, -limits.RAMP_DAMPING * (1 - gain))
        force = self.passivity.damp(force, self.speed, dt)
        most = min(self.peak, limits.HARD_CEILING)
        if self.square >= self.continuous**2:
            most = min(most, self.continuous)
        self.full = length(force) > most or self.passivity.share < 1
        force = capped(force, most)
        before = capped(self.sent, length(force))  # a force decreases at once: one that lags goes on pushing the hand
        self.sent = along(before, capped(along(force, before, -1.0), limits.SLEW * max(dt, 0.0)), 1.0)
        return self.sent

    def zero(self) -> Vector:
        """Remove all force at once."""
        self.sent, self.full = ZERO, False
        return ZERO

    @property
    def runs_away(self) -> bool:
        """Return whether the fingertip is faster than any hand."""
        return not length(self.speed) <= limits.TOP_SPEED
