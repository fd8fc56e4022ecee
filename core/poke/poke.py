"""The poke as data: events of mouse, tablet or script become the fingertips of a session.

Pure: `on_event(state, event)` returns a new state; nothing here knows Blender. Points are in the session's space [m]:

    Hit (what a ray meets) -> Aim (where and which way to press) -> PokeTip (how far it is) -> session.Finger
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, auto

from ..constants import MAX_FINGERTIPS
from ..session import Finger
from ..vectors import Vector, along, dot, length, scaled
from .tip import Aim, PokeTip, leaving, led, stepped, unit

STEEP = 3.0  # times farther along the view than across it: no surface that the pointer goes along, but an edge of it
OPPOSITE = -0.2  # cosine of the angle between two normals from which on two fingertips pinch


class Kind(Enum):
    """Name what can happen; the number an event carries is in brackets."""

    MOVE = auto()
    PRESS = auto()
    RELEASE = auto()
    FINGER = auto()  # [1, 2 or 3]
    TICK = auto()  # [s]
    # what the state has no part in
    PAUSE = auto()
    KEEP = auto()
    LEAVE = auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class Hit:
    """Where a ray meets a body: point [m], unit normal outward, and which body."""

    point: Vector
    normal: Vector
    body: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeEvent:
    """One event of a poke.

    kind: what has happened.
    hit: what the pointer's ray meets.
    view: unit direction of that ray.
    pressure: of the pen, 0 to 1.
    amount: the number that the kind asks for.
    """

    kind: Kind
    hit: Hit | None = None
    view: Vector = (0.0, 0.0, -1.0)
    pressure: float = 1.0
    amount: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeState:
    """Settings and fingertips of a poke.

    radius, depth: of the next press [m].
    force: of the next press [N].
    by_force: that force pushes, and the depth is what comes of it.
    press_s, release_s: how long going in and coming out take [s].
    along_normal: press straight into the surface, as a force always does, not along the view.
    active: the finger the pointer moves.
    tips: of each finger, None where it is lifted.
    pressing: the active finger follows the pointer.
    """

    radius: float
    depth: float
    force: float = 5.0
    by_force: bool = False
    press_s: float = 0.25
    release_s: float = 0.25
    along_normal: bool = True
    active: int = 0
    tips: tuple[PokeTip | None, ...] = (None,) * MAX_FINGERTIPS
    pressing: bool = False


def on_event(state: PokeState, event: PokeEvent) -> PokeState:
    """Return the state after an event."""
    match event.kind:
        case Kind.MOVE:
            return _move(state, event)
        case Kind.PRESS:
            return _press(state, event)
        case Kind.RELEASE:
            return _release(state)
        case Kind.FINGER:
            return _choose(state, int(event.amount) - 1)
        case Kind.TICK:
            return _tick(state, event.amount)
    return state


def _tick(state: PokeState, dt: float) -> PokeState:
    times = {"press_s": state.press_s, "release_s": state.release_s}
    tips = tuple(tip and stepped(tip, dt, amount=_amount(state, tip.by_force), **times) for tip in state.tips)
    return replace(state, tips=tips)


def fingers(state: PokeState, body: int) -> tuple[Finger | None, ...]:
    """Return where each fingertip that presses a body is."""
    return tuple(tip.finger if tip and tip.body == body else None for tip in state.tips)


def with_settings(state: PokeState, **settings: float | bool) -> PokeState:
    """Return a state whose settings were changed; a press under way takes them too."""
    state = replace(state, **settings)  # type: ignore[arg-type]
    tip = state.tips[state.active]
    if not (state.pressing and tip):
        return state
    return _with_tip(state, replace(tip, radius=state.radius, wanted=_amount(state, tip.by_force)))


def lifted(state: PokeState, body: int) -> PokeState:
    """Return a state whose fingertips are off a body: it has another size, so they would be elsewhere on it."""
    tips = tuple(None if tip and tip.body == body else tip for tip in state.tips)
    return replace(state, tips=tips, pressing=state.pressing and tips[state.active] is not None)


def _move(state: PokeState, event: PokeEvent) -> PokeState:
    tip = state.tips[state.active]
    if not (state.pressing and tip):
        return state
    on_body = event.hit and event.hit.body == tip.body
    goal = _aim(state, event.hit, event.view, by_force=tip.by_force) if event.hit and on_body else tip.goal
    if _leaps(along(goal.at, tip.goal.at, -1.0), event.view, tip.radius):
        tip = replace(tip, aim=goal, goal=goal, way=(), reached=0.0, depth=0.0)
    wanted = _amount(state, tip.by_force) * event.pressure
    return _pinched(_with_tip(state, replace(led(tip, goal), wanted=wanted)))


def _leaps(way: Vector, view: Vector, radius: float) -> bool:
    """Tell whether a way leads from one part of the surface to another behind or before it, not along it."""
    deeper = abs(dot(way, view))
    return deeper > radius and deeper > STEEP * length(along(way, view, -dot(way, view)))


def _press(state: PokeState, event: PokeEvent) -> PokeState:
    if event.hit is None:
        return state
    aim = _aim(state, event.hit, event.view, by_force=state.by_force)
    wanted = _amount(state, state.by_force) * event.pressure
    tip = PokeTip(
        body=event.hit.body, aim=aim, goal=aim, radius=state.radius, wanted=wanted, by_force=state.by_force
    )  # fmt: skip
    return _pinched(replace(_with_tip(state, tip), pressing=True))


def _pinched(state: PokeState) -> PokeState:
    """Let two fingertips that press one body from opposite sides go towards each other."""
    tip = state.tips[state.active]
    assert tip
    across = [
        (i, other) for i, other in enumerate(state.tips)
        if other and i != state.active and other.body == tip.body and not other.leaving
        and dot(other.goal.outward, tip.goal.outward) < OPPOSITE
    ]  # fmt: skip
    if len(across) != 1:
        return state
    (index, other), = across
    way = along(other.goal.at, tip.goal.at, -1.0)
    there, back = unit(way, tip.goal.inward), unit(scaled(way, -1.0), other.goal.inward)
    tips = list(state.tips)
    aim = replace(tip.aim, inward=there) if tip.reached == 0 else tip.aim
    tips[state.active] = replace(tip, aim=aim, goal=replace(tip.goal, inward=there))
    tips[index] = replace(other, goal=replace(other.goal, inward=back))  # it turns on its way, without a jump
    return replace(state, tips=tuple(tips))


def _release(state: PokeState) -> PokeState:
    tip = state.tips[state.active]
    if not (state.pressing and tip):
        return state
    return replace(_with_tip(state, leaving(tip)), pressing=False)


def _choose(state: PokeState, chosen: int) -> PokeState:
    """Choose a finger. One that presses stays, so that a pinch can be set up; chosen again it leaves."""
    if not 0 <= chosen < MAX_FINGERTIPS:
        return state
    if chosen == state.active:
        tip = state.tips[chosen]
        if state.pressing or tip is None or tip.leaving:
            return state
        return _with_tip(state, leaving(tip))
    return replace(state, active=chosen, pressing=False)


def _amount(state: PokeState, by_force: bool) -> float:
    return state.force if by_force else state.depth


def _aim(state: PokeState, hit: Hit, view: Vector, *, by_force: bool) -> Aim:
    x, y, z = hit.normal
    # pushed askew, a fingertip would jam: it is led sideways, and the surface would hold it with any force there
    straight = state.along_normal or by_force
    return Aim(hit.point, hit.normal, (-x, -y, -z) if straight else view)


def _with_tip(state: PokeState, tip: PokeTip) -> PokeState:
    return replace(state, tips=tuple(tip if i == state.active else old for i, old in enumerate(state.tips)))

