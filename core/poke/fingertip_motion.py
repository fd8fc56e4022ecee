"""A fingertip of a poke: its aim, its progress into the body, and its motion.

A fingertip starts where its sphere touches the surface and goes in from there. A drag moves it over the surface along
the path of the pointer, not straight through the body. Points are in the session's space [m].
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

from ..base import TICK
from ..constants import TRAVEL
from ..session import Finger
from ..vectors import Vector, along, length, scaled

SLIDE_S = 0.04  # [s] time constant with which a dragged fingertip follows, so that no jump tears at the skin


@dataclass(frozen=True, slots=True)
class Aim:
    """The point that a fingertip touches [m], the outward unit normal there, and the unit direction of the press."""

    at: Vector
    outward: Vector
    inward: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeTip:
    """One fingertip of a poke.

    body: index of the body that it presses.
    aim: its present aim.
    goal: the aim to which a drag moves it.
    way: aims that it passes on the way to the goal.
    radius: radius of its sphere [m].
    wanted: target depth [m] or force [N].
    by_force: whether a force pushes it.
    reached: the part of the target reached so far [m] or [N].
    depth: present depth if no force pushes it [m].
    via: its places at equal intervals in the last step, without the last one [m].
    fresh_contact: whether it came down in the last step.
    leaving: whether it moves out of the body.
    """

    body: int
    aim: Aim
    goal: Aim
    way: tuple[Aim, ...] = ()
    radius: float
    wanted: float
    by_force: bool = False
    reached: float = 0.0
    depth: float = 0.0
    via: tuple[Vector, ...] = ()
    fresh_contact: bool = False
    leaving: bool = False

    @property
    def finger(self) -> Finger:
        """Return the fingertip in the form that a session takes."""
        if not self.by_force:
            return Finger(self.place, self.radius, via=self.via, fresh_contact=self.fresh_contact)
        return Finger(self.place, self.radius, self.reached, self.aim.inward, self.via, self.fresh_contact)

    @property
    def place(self) -> Vector:
        """Return the place of its centre [m]; if a force pushes it, the place at which it just touches."""
        touching = along(self.aim.at, self.aim.outward, self.radius)
        return touching if self.by_force else along(touching, self.aim.inward, self.depth)


def leaving(tip: PokeTip) -> PokeTip:
    """Return a fingertip that moves out from its present place."""
    # the target becomes what it has reached, so that an unfinished press takes release_s too
    reached = tip.reached if tip.by_force else tip.depth
    return replace(tip, leaving=True, wanted=reached, reached=reached)


def led(tip: PokeTip, goal: Aim) -> PokeTip:
    """Return a fingertip with a new goal, which it approaches over its previous goals."""
    last = tip.way[-1] if tip.way else tip.aim
    far = length(along(tip.goal.at, last.at, -1.0)) > TRAVEL * tip.radius
    return replace(tip, way=(*tip.way, tip.goal) if far else tip.way, goal=goal)


def stepped(tip: PokeTip, dt: float, *, amount: float, press_s: float, release_s: float) -> PokeTip | None:
    """Return a fingertip a step dt [s] later, with the places that it passed; see `moved`."""
    far = _share(dt) * sum(length(along(b, a, -1.0)) for a, b in itertools.pairwise(_places(tip)))
    parts = max(1, min(round(dt / TICK), math.ceil(far / (TRAVEL * tip.radius))))
    via, now, fresh_contact = [], tip, tip.reached == 0
    for _ in range(parts):
        part = moved(now, dt / parts, amount=amount, press_s=press_s, release_s=release_s)
        if part is None:
            return None
        via.append(part.place)
        now = part
    return replace(now, via=tuple(via[:-1]), fresh_contact=fresh_contact)


def moved(tip: PokeTip, dt: float, *, amount: float, press_s: float, release_s: float) -> PokeTip | None:
    """Return a fingertip a time dt [s] later, None once it has left the surface.

    Args:
        amount: depth [m] or force [N] of a full press.
        press_s: duration of going in for a full press [s].
        release_s: duration of coming out [s].
    """
    if tip.leaving:
        most = _travel(tip.wanted, release_s, dt)
        reached = tip.reached - most
        if reached <= 1e-9:
            return None
    else:
        most = _travel(max(tip.wanted, amount), press_s, dt)
        reached = tip.reached + max(-most, min(most, tip.wanted - tip.reached))
    aim, way = _slid(tip, _share(dt))
    return replace(tip, aim=aim, way=way, reached=reached, depth=min(reached, tip.depth + most))


def _share(dt: float) -> float:
    """Return the share of its remaining path that a fingertip slides in a time dt [s]."""
    return -math.expm1(-dt / SLIDE_S)


def _places(tip: PokeTip) -> list[Vector]:
    return [tip.aim.at, *(each.at for each in tip.way), tip.goal.at]


def _slid(tip: PokeTip, share: float) -> tuple[Aim, tuple[Aim, ...]]:
    """Return the aim of a fingertip after a share of its remaining path, and the aims that it has yet to pass."""
    aims = [*tip.way, tip.goal]
    legs = [length(along(b, a, -1.0)) for a, b in itertools.pairwise(_places(tip))]
    left, here, passed = share * sum(legs), tip.aim, 0
    while passed < len(tip.way) and left >= legs[passed]:
        left, here, passed = left - legs[passed], aims[passed], passed + 1
    leg = legs[passed]
    return _between(here, aims[passed], left / leg if leg > 0 else share), tip.way[passed:]


def _between(aim: Aim, goal: Aim, share: float) -> Aim:
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
    """Return the unit vector along another, or `otherwise` if that is almost 0."""
    long = length(a)
    return scaled(a, 1 / long) if long > 1e-6 else otherwise
