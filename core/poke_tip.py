"""A fingertip of a poke: where it is aimed, how far it has gone in, and how it moves on.

A fingertip starts where its sphere touches the surface and goes in from there. Points are in the session's space [m].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from .session import Finger
from .vectors import Vector, along, length, scaled

SLIDE_S = 0.04  # [s] a dragged fingertip lags this much: no jump tears at the skin


@dataclass(frozen=True, slots=True)
class Aim:
    """Where a fingertip touches [m] and two unit vectors: out of the surface, and inward along the press."""

    at: Vector
    outward: Vector
    inward: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeTip:
    """One fingertip of a poke.

    body: the one it presses.
    aim: where it is now.
    goal: where a drag leads it.
    radius: of its sphere [m].
    wanted: depth [m] or force [N].
    by_force: it is pushed by a force.
    reached: of what is wanted, so far.
    leaving: it moves out of the body.
    """

    body: int
    aim: Aim
    goal: Aim
    radius: float
    wanted: float
    by_force: bool = False
    reached: float = 0.0
    leaving: bool = False

    @property
    def finger(self) -> Finger:
        """Return where the fingertip is, for a session."""
        touching = along(self.aim.at, self.aim.outward, self.radius)
        if self.by_force:
            return Finger(touching, self.radius, self.reached, self.aim.inward)
        return Finger(along(touching, self.aim.inward, self.reached), self.radius)


def leaving(tip: PokeTip) -> PokeTip:
    """Return a fingertip that comes out from where it is."""
    # from what it has reached, so that release_s holds for a press cut short too
    return replace(tip, leaving=True, wanted=tip.reached)


def moved(tip: PokeTip, dt: float, *, amount: float, press_s: float, release_s: float) -> PokeTip | None:
    """Return a fingertip a time dt [s] later, None when it has left the surface.

    Args:
        amount: depth [m] or force [N] of a whole press, which takes
        press_s: to go in and
        release_s: to come out [s].
    """
    if tip.leaving:
        reached = tip.reached - _travel(tip.wanted, release_s, dt)
        if reached <= 1e-9:
            return None
    else:
        most = _travel(max(tip.wanted, amount), press_s, dt)
        reached = tip.reached + max(-most, min(most, tip.wanted - tip.reached))
    return replace(tip, aim=_slid(tip.aim, tip.goal, -math.expm1(-dt / SLIDE_S)), reached=reached)


def _slid(aim: Aim, goal: Aim, share: float) -> Aim:
    return Aim(
        _toward(aim.at, goal.at, share),
        unit(_toward(aim.outward, goal.outward, share), goal.outward),
        unit(_toward(aim.inward, goal.inward, share), goal.inward),
    )


def _travel(whole: float, duration: float, dt: float) -> float:
    return math.inf if duration <= 0 else whole * dt / duration


def _toward(a: Vector, b: Vector, share: float) -> Vector:
    return along(a, along(b, a, -1.0), share)


def unit(a: Vector, otherwise: Vector) -> Vector:
    """Return a vector of length 1 along another, or what to take where that has no direction."""
    long = length(a)
    return scaled(a, 1 / long) if long > 1e-6 else otherwise
