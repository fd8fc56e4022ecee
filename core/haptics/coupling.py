"""A virtual coupling: what joins a fingertip of the device to its sphere in the model, so that no body can shake it.

    q   follows the fingertip as a mass on a critically damped spring would: the noise of its converters stays outside
    y   = q + u   where the sphere is in the model
    F   what the model answers at y, and c(F) how far the sphere is to lag behind q under it
    u   goes to c(F) along F; the fingertip gets no more than the force whose lag is |u|

A body softer than the device's cap has no lag, c = 0: the fingertip gets the model's force. Of a stiffer one it gets
that of the body in series with a spring, 1/cap - 1/K: together as stiff as the cap. A sphere that presses a stiff body
too far for a moment costs nothing, for the hand gets the force of the spring.

Source: Colgate, Stanley and Brown 1995, Issues in the haptic display of tool use; the lag that ends below the cap is
ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from ..vectors import ZERO, Vector, along, capped, length, scaled
from .safety import SPEED_TIME

FOLLOW: Final = 200.0  # [1/s] how fast q follows: skin on it then feels 0.2 N of a 12-bit converter's noise, not 4 N
LAG: Final = 0.3  # of the way to its lag u goes in a tick, over how much stiffer than the cap the body is
SMOOTH: Final = 0.3  # of the way to the newest force of the model, which touches vertex by vertex, in a tick
STIFFER: Final = 1.1  # times the slope of its law a body may be under a round tip, at an edge or between two fingers
VISCOUS: Final = 6.0  # [N s/m] of a touch: what the lags of q and F give back otherwise


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """How stiff a body is: two slopes [N/m] and the force of the knee between them [N]."""

    k1: float
    k2: float
    knee: float

    def at(self, force: float) -> float:
        """Return the stiffness [N/m] at a force [N]."""
        return self.k1 if force <= self.knee else self.k2


@dataclass(slots=True)
class Coupling:
    """The coupling of one fingertip.

    near: q [m], None before the first position.
    speed: of q [m/s].
    at: the fingertip's last position [m].
    quick: the fingertip's speed over SPEED_TIME [m/s].
    lag: u [m].
    force: of the model, smoothed [N].
    """

    near: Vector | None = None
    speed: Vector = ZERO
    at: Vector = ZERO
    quick: Vector = ZERO
    lag: Vector = ZERO
    force: Vector = ZERO

    def follow(self, x: Vector, tick: float) -> None:
        """Take where the fingertip is [m] after a tick [s]; implicit, so stable at any rate."""
        if self.near is None:
            self.near = self.at = x
        way, self.at = along(x, self.at, -1.0), x
        self.quick = along(self.quick, along(scaled(way, 1 / tick), self.quick, -1.0), tick / (SPEED_TIME + tick))
        pull, drag = tick * FOLLOW**2, 1 + 2 * FOLLOW * tick + (FOLLOW * tick) ** 2
        self.speed = scaled(along(self.speed, along(x, self.near, -1.0), pull), 1 / drag)
        self.near = along(self.near, self.speed, tick)

    def place(self, slopes: Slopes, cap: float) -> Vector:
        """Return where the sphere is to be [m], over a body with slopes, below the device's stiffness cap [N/m]."""
        assert self.near
        push = length(self.force)
        wanted = scaled(self.force, self._lag_of(push, slopes, cap) / push) if push else ZERO
        share = LAG / max(slopes.at(push) / cap, 1.0)
        self.lag = along(self.lag, along(wanted, self.lag, -1.0), share)
        return along(self.near, self.lag, 1.0)

    def take(self, force: Vector, slopes: Slopes, cap: float) -> Vector:
        """Take the model's force [N] of this tick; return that of the fingertip."""
        touches = any(force)
        self.force = along(self.force, along(force, self.force, -1.0), SMOOTH) if touches else ZERO
        sprung = capped(self.force, self._force_of(length(self.lag), slopes, cap))
        return along(sprung, self.quick, -VISCOUS) if touches else ZERO

    def _compliances(self, slopes: Slopes, cap: float) -> tuple[float, float]:
        """Return the compliance [m/N] of the coupling below the knee and beyond it."""
        return max(1 / cap - 1 / max(slopes.k1, 1e-9), 0.0), max(1 / cap - 1 / max(slopes.k2, 1e-9), 0.0)

    def _lag_of(self, force: float, slopes: Slopes, cap: float) -> float:
        below, beyond = self._compliances(slopes, cap)
        return below * min(force, slopes.knee) + beyond * max(force - slopes.knee, 0.0)

    def _force_of(self, lag: float, slopes: Slopes, cap: float) -> float:
        """Return the force [N] of which a length [m] is the lag, the largest where there are several."""
        below, beyond = self._compliances(slopes, cap)
        left = lag - below * slopes.knee
        if left < 0:
            return lag / below
        return slopes.knee + left / beyond if beyond > 0 else math.inf
