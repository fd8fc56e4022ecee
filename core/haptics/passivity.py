"""The energy that a fingertip's force takes from a hand and gives it: it may not give more.

Nothing here may be weakened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..vectors import ZERO, Vector, along, dot, scaled

PASSIVITY_DAMPING = 12.0  # [N s/m] the most the passivity controller adds: a tenth of tip mass over tick
PASSIVITY_SPEED = 2e-3  # [m/s] slower than this is converter noise
GRAIN = 4e-4  # [m] five times the noise of a 12-bit converter at the tip
STORE_TIME = 0.050  # [s] without force: the spring is relaxed, nothing is stored
ALLOWED = 5e-4  # [J] that a touch may give back beyond what it took; from there on its force yields,
YIELD_ENERGY = 2.5e-4  # to 1/e for each so many [J]
KNOWN_LATE = 6e-3  # [s] after which what a force gave has been counted, and the force has ended
SPARE = 2e-3  # [J] of what was taken that are kept once the device let go: what it gave is known some pieces late
GRAIN_ENERGY = 1e-4  # [J] less is the noise of the converters


def _is_far(x: Vector, before: Vector) -> bool:
    way = along(x, before, -1.0)
    return dot(way, way) > GRAIN**2


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
    share: of the force that is left, once the touch gave back too much; it ends with the touch.
    floor: stored energy below which it falls [J].
    unwanted: for how long no force has been wanted [s].

    Source: Hannaford and Ryu, time-domain passivity control; a force that yields until the touch is over is ours.
    """

    stored: float = 0.0
    least: float = 0.0
    idle_since: float | None = None
    at: Vector | None = None
    begin: Vector | None = None
    total: Vector = ZERO
    count: int = 0
    share: float = 1.0
    floor: float = -ALLOWED
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
        elif now - self.idle_since > STORE_TIME:
            self.stored = min(self.stored, 0.0)  # what was dissipated pays for nothing later

    def _count(self, x: Vector) -> None:
        """Count the piece under way, which ends at x [m]."""
        self.stored -= dot(self.total, along(x, self.begin or x, -1.0)) / self.count
        self.least = min(self.least, self.stored)
        if self.stored < self.floor:
            self.share *= math.exp((self.stored - self.floor) / YIELD_ENERGY)
            self.floor = self.stored
        self.begin, self.total, self.count = x, ZERO, 0

    def skip(self) -> None:
        """Drop the piece under way: a sensor failed."""
        self.at, self.begin, self.total, self.count = None, None, ZERO, 0

    def lose(self) -> None:
        """Note that the device let go: a fingertip that sank in is pushed out with no more than the hand gave."""
        self.floor = min(SPARE, self.stored - GRAIN_ENERGY)

    def want(self, force: Vector, dt: float) -> Vector:
        """Return what is left of a force [N] wanted for a time [s]; wanted none for a while, the touch is over."""
        self.unwanted = 0.0 if force != ZERO else self.unwanted + dt
        if self.unwanted > STORE_TIME:
            self.share, self.floor = 1.0, min(self.stored, 0.0) - ALLOWED
        return scaled(force, self.share)

    def afford(self, force: Vector, speed: Vector) -> Vector:
        """Return the force [N], less where at a speed [m/s] it would give more than is left before that is known."""
        given, left = KNOWN_LATE * dot(force, speed), max(self.stored - self.floor, 0.0)
        return scaled(force, left / given) if given > left else force

    def damp(self, force: Vector, speed: Vector, dt: float) -> Vector:
        """Return the force [N], damped so that what was given too much is taken back."""
        squared = dot(speed, speed)
        if self.stored >= 0 or force == ZERO or squared < PASSIVITY_SPEED**2 or dt <= 0:
            return force
        return along(force, speed, -min(-self.stored / (squared * dt), PASSIVITY_DAMPING))
